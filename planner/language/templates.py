"""Template sentences to train the slot heads: many wordings of every command, and of none."""

from __future__ import annotations

from itertools import product

from planner.command import COMMANDS, Command
from planner.language.rules.phrase_search import phrase_lists
from planner.language.slots import SLOTS
from tissue_sim.patient.tube_names import USUAL_STRUCTURES

_LISTS = phrase_lists("templates")
_ORDINALS = {"1": "first", "2": "second", "3": "third"}
_TUBES = {f"{tube}": f"{tube} tube" for tube in ("left", "right", "third")} | {
    one: one for one in USUAL_STRUCTURES
}


def wordings(command: Command) -> list[str]:
    """Return wordings of a command."""
    said = SLOTS[command.text]
    kind, what = said["kind"], said.get("what", "")
    if kind == "move":
        made = [
            m.format(arm) for m, arm in product(_LISTS["move"][what], _LISTS["arms"][said["arm"]])
        ]
    elif kind in _LISTS["jaws"]:
        made = [
            m.format(name)
            for m, name in product(_LISTS["jaws"][kind], _LISTS["grippers"][said["arm"]])
        ]
    elif command.deed:
        made = [m.format(_TUBES[said["tube"]]) for m in _LISTS["deeds"][kind]]
    elif command.task:
        names = [name for name in (_ORDINALS.get(what), _TUBES.get(said.get("tube", ""))) if name]
        made = [m.format(*names) for m in _LISTS["tasks"][kind]]
    else:
        made = list(_LISTS["words"][kind])
    return [
        frame.format(text)
        for text in (command.text, *made)
        for frame in _LISTS["frames"]["of_commands"]
    ]


def other_sentences() -> list[str]:
    """Return sentences that mean no command."""
    others = _LISTS["others"]
    deeds = [f"{deed} the {thing}" for deed, thing in product(others["deeds"], others["things"])]
    framed = [frame.format(text) for frame, text in product(others["frames"], COMMANDS)]
    return [*deeds, *framed, *others["elsewhere"]]
