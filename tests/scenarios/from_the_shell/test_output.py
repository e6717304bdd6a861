"""Tests of printed reports: tables in a file keep their whole width."""

from rich.table import Table

from scenarios.files.outside_text import output

CELL = "a value that is long enough"


def wide() -> Table:
    table = Table(*("a heading" for _ in range(6)))
    table.add_row(*(CELL for _ in range(6)))
    return table


def test_tables_are_whole_in_a_file(capsys, monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    output().print(wide())
    assert capsys.readouterr().out.count(CELL) == 6


def test_a_width_that_is_asked_for_is_kept(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    output().print(wide())
    assert max(map(len, capsys.readouterr().out.splitlines())) == 60
