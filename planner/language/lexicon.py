"""The words surgeons use (lexicon.toml), each with the slot that it fills."""

from __future__ import annotations

import tomllib
from itertools import product
from pathlib import Path
from typing import NamedTuple


class Sense(NamedTuple):
    """What a phrase says.

    Attributes:
        slot: A table of lexicon.toml; or "tube"; or a side without a noun: "which", or "side" where
            it may be a direction as well.
        value: Of the slot.
    """

    slot: str
    value: str


_BEFORE = ("", "the ", "on ", "on the ", "to the ", "onto the ", "at the ", "of the ", "from the ")
_SIDES = ("left", "right")
_NOUNS = {
    "arm": (
        "arm", "hand", "instrument", "tool", "manipulator", "gripper", "grippers", "jaw", "jaws",
        "fingers", "grasper", "forceps", "side instrument", "hand instrument", "claw",
    ),
    "tube": ("tube", "vessel", "structure", "tubular structure", "pipe"),
    "which": ("one", "side"),
}  # fmt: skip


def _listed() -> dict[str, Sense]:
    tables = tomllib.loads(Path(__file__).with_name("lexicon.toml").read_text("utf-8"))
    return {
        " ".join(phrase.split()): Sense(slot, value)
        for slot, values in tables.items()
        for value, phrases in values.items()
        for phrase in phrases.split(",")
    }


def _sided() -> dict[str, Sense]:
    """Sides of arms, of tubes, or of either; "to the left arm" is no direction."""
    of_noun = {
        f"{before}{side} {noun}": Sense(slot, side)
        for slot, nouns in _NOUNS.items()
        for before, side, noun in product(_BEFORE, _SIDES, nouns)
    }
    on = {
        f"{before}{side}": Sense("which", side) for before in ("on ", "on the ") for side in _SIDES
    }
    both = {f"both {noun}": Sense("arm", "both") for noun in _NOUNS["arm"]}
    heard = {f"write {noun}": Sense("arm", "right") for noun in _NOUNS["arm"]}
    bare = {side: Sense("side", side) for side in _SIDES}
    return of_noun | on | both | heard | bare


LEXICON: dict[str, Sense] = _listed() | _sided()
LONGEST = max(len(phrase.split()) for phrase in LEXICON)
