"""Tests of what is kept of a file: it is loaded once, and again when the file is written anew."""

import os
from pathlib import Path

import pytest

from planner.learning.networks import kept


def written(path: Path, text: str, at_ns: int) -> Path:
    path.write_text(text)
    os.utime(path, ns=(at_ns, at_ns))
    return path


def test_a_file_is_loaded_once_until_it_is_written_anew(tmp_path: Path) -> None:
    loaded = kept(lambda path: [path.read_text()])
    one = loaded(written(tmp_path / "a", "one", 1))
    assert loaded(tmp_path / "a") is one
    assert loaded(written(tmp_path / "a", "two", 2)) == ["two"]
    assert loaded(written(tmp_path / "b", "three", 2)) == ["three"]


def test_a_file_that_is_not_there_yet_is_asked_for_again(tmp_path: Path) -> None:
    loaded = kept(Path.read_text)
    with pytest.raises(FileNotFoundError):
        loaded(tmp_path / "a")
    assert loaded(written(tmp_path / "a", "one", 1)) == "one"
