"""The score of an interpreter on sentences with known meanings, and how a reading is written."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from planner.command import COMMANDS, Command
from planner.correction import opposite
from planner.language.reading import Reading, Said
from planner.language.rules.sizes import LARGE_M, SMALL_M
from planner.language.sentence_sets import ASK_BACK, OUT_OF_SCOPE, Row
from planner.person.interpretation import relative_to
from planner.person.orders import Order
from planner.scene.next_task import NotNowError

_VAGUE = {"small": f"{1e3 * SMALL_M:g} mm", "large": f"{1e3 * LARGE_M:g} mm"}
_USUAL = {"duct": "left", "artery": "right"}
_OF_TUBES = {"left tube": "duct", "right tube": "artery"}  # as in most patients


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


def read_as(row: Row, read: Callable[[str], Reading]) -> str:
    """Return how a row is read, by the order that it tells to be the latest.

    Words that allow an act may also order it, where nothing is forbidden.
    """
    reading = read(row.said)
    if reading.allows and (row.expected.startswith("allow: ") or reading.command is None):
        return f"allow: {reading.allows.in_words}"
    said = reading.said[:1]
    refers = said and (said[0].relative or said[0].command.word in ("repeat", "undo"))
    if refers and (row.latest or said[0].relative):
        return _after(row.latest, said[0])
    return as_written(reading)


def _after(latest: str, said: Said) -> str:
    """Return what a word means that refers to the latest order."""
    text, _, size = latest.partition(" @ ")
    correction = COMMANDS[text].correction if latest else None
    if said.relative is None:
        if said.command.word == "repeat" or correction is None:
            return latest if said.command.word == "repeat" else said.command.text
        return _sized(Said(command=COMMANDS[opposite(correction).text], size_m=_metres(size)))
    order = correction and Order(correction=correction, distance_m=_metres(size))
    try:
        meant = relative_to(order, said.relative, said.size_m)
    except NotNowError:
        return "ask"
    assert meant.correction is not None
    return _sized(Said(command=COMMANDS[meant.correction.text], size_m=meant.distance_m))


def _metres(size: str) -> float:
    return 1e-3 * float(_VAGUE.get(size, size or "4 mm").removesuffix(" mm"))


def as_written(reading: Reading) -> str:
    """Return a reading as the protocol of the sentence sets writes it."""
    if reading.by == "rule" and reading.reply.startswith("Refused"):
        return "refuse"
    if reading.question:
        return f"question: {reading.question}"
    speed = f"speed: {reading.speed}" if reading.speed else ""
    tool = f"tool: {reading.applier}" if reading.applier else ""
    besides = [one for one in (speed, tool) if one]
    if besides and reading.command is None:
        return " ; ".join(besides)
    if reading.by == "warning" or reading.forbids:
        refused = reading.reply.startswith("Refused")
        return "hold, refused" if refused else _held(reading)
    if reading.command is None:
        return "ask" if reading.guesses else "none"
    first = Said(command=reading.command, size_m=reading.size_m, side=reading.side)
    for said in (first, *reading.then):
        if said.side and said.side != _USUAL.get(said.command.structure or ""):
            return "ask"  # the robot sees another side
    return " ; ".join([*besides, *map(_sized, (first, *reading.then))])


def is_right(expected: str, written: str) -> bool:
    """Return whether a reading is the expected one.

    A tube and its structure are the same; so are all ways to hold, and all that changes
    nothing. Lengths count to half a millimetre. Who refuses and holds the arms does both.
    """
    if written == "hold, refused":
        return _plain(expected) in ("hold", "refuse")
    return _plain(expected) == _plain(written)


def _held(reading: Reading) -> str:
    return f"hold: {', '.join(one.text for one in reading.forbids)}" if reading.forbids else "hold"


def _sized(said: Said) -> str:
    if said.size_m is None:
        return said.command.text
    size_mm = f"{1e3 * said.size_m:.1f}".removesuffix(".0")
    return f"{said.command.text} @ {size_mm} mm"


def _plain(written: str) -> str:
    if written in ("stop", "pause", "hold"):
        return "hold"
    if written in ("ask", "none"):
        return "changes nothing"
    parts = []
    for part in written.split(" ; "):
        command, at, size = part.partition(" @ ")
        known = COMMANDS[command].seen(duct="left").text if command in COMMANDS else command
        size = _VAGUE.get(size, size)
        half_mm = f"{round(2.0 * float(size.removesuffix(' mm'))) / 2:g}" if size else ""
        parts.append(f"{known}{at}{half_mm}")
    joined = " ; ".join(parts)
    if joined.startswith(("hold", "allow")):
        for tube, structure in _OF_TUBES.items():
            joined = joined.replace(tube, structure)
    return joined
