"""Sentences with known meanings, to learn from."""

from __future__ import annotations

import csv
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from planner.command import COMMANDS
from planner.language.rules.questions import QUESTIONS

OUT_OF_SCOPE, ASK_BACK = "-", "?"
_ACT = r"((clip|cut)( (duct|artery|(left|right|third) tube))?|open( (left|right) gripper)?)"
_BY_PROTOCOL = re.compile(
    rf"hold(: no {_ACT}(, no {_ACT})*)?|allow: {_ACT}"
    rf"|tool: (large|slim|other)"
    rf"|speed: (slower|faster|half|normal)|question: ({'|'.join(QUESTIONS)})|ask|refuse|none"
)
_SIZE = re.compile(r"small|large|\d+(\.\d+)? mm")
_AFTER = re.compile(r"\[after: (?P<latest>[^\]]+)\] (?P<said>.+)")


class Row(NamedTuple):
    """A sentence and its expected meaning, as its set writes it.

    A sentence that refers to the latest order begins with it: "[after: cut duct] once more".
    """

    sentence: str
    expected: str

    @property
    def said(self) -> str:
        """Return what the person says."""
        found = _AFTER.fullmatch(self.sentence)
        return found["said"] if found else self.sentence

    @property
    def latest(self) -> str:
        """Return the order before, as the protocol writes it; "" if the sentence tells none."""
        found = _AFTER.fullmatch(self.sentence)
        return found["latest"] if found else ""


def names_a_command(expected: str) -> bool:
    """Return whether it is a command's text, `OUT_OF_SCOPE` or `ASK_BACK`."""
    return expected in (*COMMANDS, OUT_OF_SCOPE, ASK_BACK)


def keeps_the_protocol(expected: str) -> bool:
    """Return whether it is a meaning, or several, of the protocol of the sentence sets."""
    return all(map(_is_of_protocol, expected.split(" ; ")))


def _is_of_protocol(part: str) -> bool:
    text, at, size = part.partition(" @ ")
    command = COMMANDS.get(text)
    if command is None or not at:
        return command is not None or _BY_PROTOCOL.fullmatch(part) is not None
    return command.correction is not None and _SIZE.fullmatch(size) is not None


def read_rows(path: Path, is_meaning: Callable[[str], bool] = names_a_command) -> list[Row]:
    """Return the rows of a tab-separated file with the columns of `Row`; blank lines are none.

    Raises:
        OSError: the file cannot be read.
        ValueError: it lacks a column, or an expected meaning is none.
    """
    with path.open(encoding="utf-8", newline="") as file:
        lines = csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)
        if lines.fieldnames != [*Row._fields]:
            raise ValueError(f"{path}: its first line must be {' and '.join(Row._fields)!r}")
        said = [(line["sentence"], line["expected"]) for line in lines if any(line.values())]
    rows = [Row(sentence, expected or "") for sentence, expected in said]
    for row in rows:
        if not is_meaning(row.expected) or not is_meaning(row.latest or row.expected):
            raise ValueError(f"{path}: {row.sentence!r}: no command is {row.expected!r}")
    return rows


def rows_named(
    names: Sequence[str], script: str, is_meaning: Callable[[str], bool] = names_a_command
) -> list[Row]:
    """Return the rows of the sets that a script was given; end it in one line if it cannot."""
    if not names:
        sys.exit(f"usage: python -m {script} SET.tsv ...")
    try:
        return [row for name in names for row in read_rows(Path(name), is_meaning)]
    except (OSError, ValueError) as error:
        sys.exit(str(error))


def holds(meaning: str) -> bool:
    """Return whether the arms stay, by a meaning as the protocol of the sentence sets writes it."""
    return meaning in ("stop", "pause") or meaning.startswith("hold")
