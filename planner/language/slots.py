"""The slots of each command, which the words of a sentence fill one by one."""

from __future__ import annotations

from collections.abc import Mapping, Set

from planner.command import COMMANDS, Command
from planner.correction import DIRECTION_ENDOSCOPE
from tissue_sim.patient.tube_names import OPTIONAL_TUBES

Filled = Mapping[str, Set[str]]
"""The values that words give to each slot; two in one contradict each other."""

DIRECTIONS = frozenset(DIRECTION_ENDOSCOPE)
ORDINALS = frozenset({"1", "2", "3"})
TUBE_KINDS = frozenset({"clip", "go_back", "cut", "cut_position", "go_back_from_cut"})
_CERTAIN = ORDINALS | {"left", "right", "clip", "cut"}
_MAY_ADD: dict[str, dict[str, str]] = {
    "grab": {"arm": "left", "organ": "gallbladder"},
    "let go": {"arm": "left", "organ": "gallbladder"},
    **{kind: {"arm": "right"} for kind in TUBE_KINDS},
}
"""Slots that may be said with a kind without a change of meaning."""


def slots(command: Command) -> dict[str, str]:
    """Return a command's slots: kind, arm, tube or structure, and direction or clip, if any."""
    said = {"kind": command.word or command.deed}
    if task := command.task:
        kind = "cut_position" if task.severs else task.kind
        said = {"kind": kind, "tube": task.tube, "what": task.clip and str(task.clip)}
    elif correction := command.correction:
        kind = correction.jaw or "move"
        said = {"kind": kind, "arm": correction.arm, "what": correction.direction}
    if tube := command.structure or command.tube:
        said["tube"] = tube
    return {slot: value for slot, value in said.items() if value}


SLOTS: dict[str, dict[str, str]] = {text: slots(command) for text, command in COMMANDS.items()}
"""The slots of every command, by the command's text."""


def candidates(filled: Filled) -> list[Command]:
    """Return the commands that agree with one value of every filled slot.

    Few patients have the optional tubes, so words must name them.
    """
    named = filled.get("tube", set())
    there = (text for text in SLOTS if SLOTS[text].get("tube") not in {*OPTIONAL_TUBES} - named)
    return [COMMANDS[text] for text in there if filled and _agrees(text, filled)]


def contradicts(filled: Filled) -> bool:
    """Return whether a slot has two values."""
    return any(len(values) > 1 for values in filled.values())


def spelt_out(filled: Filled) -> Command | None:
    """Return the one command whose slots are all filled, each with one value, else None."""
    if contradicts(filled):
        return None
    whole = [c for c in candidates(filled) if SLOTS[c.text].keys() <= filled.keys()]
    return whole[0] if len(whole) == 1 else None


def named_outright(command: Command, filled: Filled) -> bool:
    """Return whether words fill every slot of a command that must not be guessed.

    These are sides and ordinals, which have few words, and what cannot be undone: clips and cuts.
    """
    said = SLOTS[command.text]
    certain = {slot for slot, value in said.items() if slot in ("arm", "tube") or value in _CERTAIN}
    return certain <= filled.keys()


def _agrees(text: str, filled: Filled) -> bool:
    said = SLOTS[text]
    allowed = _MAY_ADD.get(said["kind"], {}) | said
    return all(allowed.get(slot) in values for slot, values in filled.items())
