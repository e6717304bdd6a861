"""The score of an interpreter on sentences with known meanings."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from planner.command import COMMANDS, Command

OUT_OF_SCOPE, ASK_BACK = "-", "?"
_EXPECTED = {*COMMANDS, OUT_OF_SCOPE, ASK_BACK}


class Row(NamedTuple):
    """A sentence and its expected meaning: a command's text, `OUT_OF_SCOPE` or `ASK_BACK`."""

    sentence: str
    expected: str


@dataclass(frozen=True, kw_only=True)
class Score:
    """How many sentences were understood, and which were not.

    Attributes:
        in_scope: Sentences that mean a command, or should be asked back.
        understood: Sentences in scope with the expected reading.
        misread: Sentences in scope, each with the wrong command that was read.
        out_of_scope: Sentences that mean no command.
        moving: Sentences out of scope, each with the command that moves the robot.
    """

    in_scope: int
    understood: int
    misread: tuple[tuple[Row, str], ...]
    out_of_scope: int
    moving: tuple[tuple[Row, str], ...]


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a tab-separated file with the columns of `Row`.

    Raises:
        ValueError: An expected meaning is not a command.
    """
    with path.open(encoding="utf-8", newline="") as file:
        lines = csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)
        rows = [Row(line["sentence"], line["expected"]) for line in lines]
    for row in rows:
        if row.expected not in _EXPECTED:
            raise ValueError(f"{row.sentence!r}: no command is {row.expected!r}")
    return rows


def score(rows: Iterable[Row], read: Callable[[str], Command | None]) -> Score:
    """Score `read` on the rows; None means that it asks back."""
    read_as = [(row, read(row.sentence)) for row in rows]
    inside = [(row, c) for row, c in read_as if row.expected != OUT_OF_SCOPE]
    outside = [(row, c) for row, c in read_as if row.expected == OUT_OF_SCOPE]
    return Score(
        in_scope=len(inside),
        understood=sum(is_understood(row, c) for row, c in inside),
        misread=tuple((row, c.text) for row, c in inside if c and not is_understood(row, c)),
        out_of_scope=len(outside),
        moving=tuple((row, c.text) for row, c in outside if c and c.moves),
    )


def is_understood(row: Row, command: Command | None) -> bool:
    """Return whether a sentence in scope was read as expected, by tube or by structure."""
    return _meant(row) == _seen(command)


def _meant(row: Row) -> Command | None:
    return None if row.expected == ASK_BACK else _seen(COMMANDS[row.expected])


def _seen(command: Command | None) -> Command | None:
    """Return the command with its tube; the duct is the left one, as in most patients."""
    return command and command.seen(duct="left")
