"""Sentences with known meanings, to learn from."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import NamedTuple

from planner.command import COMMANDS

OUT_OF_SCOPE, ASK_BACK = "-", "?"
_EXPECTED = {*COMMANDS, OUT_OF_SCOPE, ASK_BACK}


class Row(NamedTuple):
    """A sentence and its expected meaning: a command's text, `OUT_OF_SCOPE` or `ASK_BACK`."""

    sentence: str
    expected: str


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


def holds(meaning: str) -> bool:
    """Return whether the arms stay, by a meaning as the protocol of the sentence sets writes it."""
    return meaning in ("stop", "pause") or meaning.startswith("hold")
