"""Read one command that a text spells out, with the length and the side that it names."""

from __future__ import annotations

from collections.abc import Sequence

from planner.command import Command
from planner.language.grammar import parse
from planner.language.reading import Said
from planner.language.rules.phrase_search import patterns
from planner.language.rules.references import without_side
from planner.language.rules.sizes import (
    Sized,
    out_of_range,
    unclear_length,
    unread_length,
    without_size,
    without_unit,
)
from planner.language.slots import spelt_out
from tissue_sim.patient.tube_names import Tube

_RE = patterns("interpreter")


def by_grammar(english: str) -> Command | None:
    """Return the command that an English sentence spells out; None if it does not."""
    parsed = parse(without_size(english).text)
    command = None if parsed.refusal else spelt_out(parsed.filled)
    return None if command is None or (parsed.unknown and command.moves) else command


def sized_in(part: str) -> Said | None:
    """Return the command that a text spells out, with length and side; None if there is none."""
    sized = without_size(part)
    plain, side = without_side(sized.text)
    command = by_grammar(plain)
    if command is None or is_placed(command, sized, part):
        return None
    return said_with(command, sized.size_m, side)


def said_with(command: Command, size_m: float | None, side: Tube | None) -> Said:
    """Return a command with a side, and with a length if it moves an arm."""
    return Said(command=command, size_m=size_m if command.correction else None, side=side)


def is_placed(command: Command, sized: Sized, english: str) -> bool:
    """Return whether a clip or a cut is to go to another place than its own: "2 mm higher"."""
    if not (command.deed or command.task):
        return False
    aside = _RE["aside"].search(english)
    return sized.measured or bool(aside and (aside["farther"] or sized.size_m))


def not_so_far(text: str, english: str, said: Sequence[Said]) -> str:
    """Return why it is not clear how far an arm shall go, or it does not go so far; or ""."""
    sizes_m = [one.size_m for one in said if one.command.correction or one.relative]
    if not sizes_m:
        return ""
    if None in sizes_m and (number := without_unit(text)):
        return f"{number!r} is no length in mm, cm or inches"
    unclear = unclear_length(text) or unread_length(english)
    return unclear or next(filter(None, map(out_of_range, sizes_m)), "")
