"""Timed instructions from a file, so that a person's words can be repeated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from planner.learning.files import from_json
from scenarios.files.errors import BadInputError, refusing

MOST_BYTES = 1_000_000
ALLOWED = 'SECONDS<tab>TEXT or {"time_s": SECONDS, "text": "TEXT"}, SECONDS at least 0'


@dataclass(frozen=True, kw_only=True)
class Timed:
    """Words for one moment of an episode.

    Attributes:
        time_s: Simulated time, at least 0.
        text: The person's words; read beforehand, and answered when the time comes.

    Raises:
        ValueError: The time is invalid, or there are no words.
    """

    time_s: float
    text: str

    def __post_init__(self) -> None:
        known = isinstance(self.time_s, int | float) and not isinstance(self.time_s, bool)
        if not known or not 0.0 <= self.time_s < math.inf:
            raise ValueError(f"{self.time_s!r} is no time in s")
        if not isinstance(self.text, str) or not self.text.strip():
            raise ValueError("there is no text")


def read_script(path: Path) -> tuple[Timed, ...]:
    """Read the lines of a file in UTF-8, each with a time and words; skip empty lines.

    Raises:
        BadInputError: The file cannot be read, or a line has another form.
    """
    try:
        if path.stat().st_size > MOST_BYTES:
            raise BadInputError(f"--instruct {path}: it has more than {MOST_BYTES} bytes")
        lines = path.read_text("utf-8-sig").split("\n")
    except OSError as error:
        raise BadInputError(f"--instruct {path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise BadInputError(f"--instruct {path}: it is not text in UTF-8") from None
    return tuple(_timed(path, n, line) for n, line in enumerate(lines, 1) if line.strip())


def _timed(path: Path, number: int, line: str) -> Timed:
    before, after = f"--instruct {path}, line {number}: ", f"; allowed: {ALLOWED}"
    with refusing(ValueError, before=before, after=after):
        return _from_json(line) if line.lstrip().startswith("{") else _from_tabbed(line)


def _from_json(line: str) -> Timed:
    try:
        entries = from_json(line)
    except ValueError as error:
        raise ValueError(f"it is not JSON: {error}") from None
    if set(entries) != {"time_s", "text"}:
        raise ValueError(f"it has {', '.join(sorted(entries)) or 'nothing'}")
    return Timed(**entries)


def _from_tabbed(line: str) -> Timed:
    time_s, tab, text = line.partition("\t")
    if not tab:
        raise ValueError("there is no tab")
    try:
        number = float(time_s)
    except ValueError:
        raise ValueError(f"{time_s!r} is no time in s") from None
    return Timed(time_s=number, text=text)
