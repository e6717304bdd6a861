"""The grammar: which slots the words of a sentence fill, or why the robot must do nothing."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from planner.command import Command
from planner.correction import OPPOSITE
from planner.language.lexicon import Meaning
from planner.language.phrases import normalised, senses
from planner.language.rules.phrase_search import patterns
from planner.language.slots import (
    DIRECTIONS,
    ORDINALS,
    TUBE_KINDS,
    Filled,
    contradicts,
    named_outright,
    spelt_out,
)

_RE = patterns("grammar")
_TURNED = ("kind", "what", "side", "particle", "preposition")  # "too" reverses their direction
Openness = Literal["unknown words", "open slots"]
_DENIED = "it says what not to do"
_OF_COMMANDS = ("kind", "arm", "tube", "organ", "what")


@dataclass(frozen=True, kw_only=True)
class Parse:
    """What the words of a sentence say.

    Attributes:
        filled: The slots.
        unknown: Words outside the lexicon.
        refusal: Why the robot must do nothing, in words; empty if there is no reason.
    """

    filled: Filled
    unknown: tuple[str, ...] = ()
    refusal: str = ""


def parse(text: str) -> Parse:
    """Return the slots that a sentence fills, its unknown words, and a reason to refuse it."""
    words = normalised(text)
    asked_for = _RE["request"].sub("", words)
    found = list(senses(asked_for.split()))
    unknown = tuple(one for one in found if isinstance(one, str))
    said = _said(one for one in found if isinstance(one, Meaning))
    asks = words == asked_for and (_RE["question"].match(words) or text.rstrip().endswith("?"))
    refusal = "it is a question" if asks else _refusal(said, unknown)
    if _DENIED not in said["refusal"] and not asks:
        if "stop" in said["kind"]:  # "stop" overrules all other words
            return Parse(filled={"kind": {"stop"}})
        if said["kind"] == {"pause"}:
            refusal = ""
    filled = _filled(said, whole=not unknown)
    if filled.get("what", set()) & {"towards", "away"} and _RE["by_a_thing"].search(words):
        refusal = refusal or "which way that is; say up, down, left, right, towards or away from me"
    return Parse(filled=filled, unknown=unknown, refusal=refusal)


def _said(found: Iterable[Meaning]) -> dict[str, set[str]]:
    """Collect values by slot; after "too" a direction is reversed."""
    said, too = defaultdict(set), False
    for slot, value in found:
        turns = too and slot in _TURNED
        said[slot].add(OPPOSITE.get(value, value) if turns else value)
        too = slot == "too" or (too and not turns)
    leaves = "away" in said["what"] and not said["too"]
    if leaves and not said["arm"] and said["tube"] | said["what"] & ORDINALS:
        said["what"] -= {"away"}
        said["kind"] |= {"go_back"}
    return said


def _refusal(said: dict[str, set[str]], unknown: tuple[str, ...]) -> str:
    """Return why the robot must do nothing; empty if there is no reason."""
    goes_back = "go_back" in said["kind"]
    if said["after"] and not goes_back:
        return "it sets a condition or a time"
    too_much = said["too"] and not unknown and not said["kind"] & {"clip", "cut"}
    tells = not (goes_back or too_much) and _tells(said, unknown)
    return min(said["refusal"], default="it tells how things are" if tells else "")


def _tells(said: dict[str, set[str]], unknown: tuple[str, ...]) -> bool:
    """Return whether the sentence describes. A wish may describe, but not for a clip or a cut."""
    deed = {"clip", "cut"} & (said["kind"] | said["state"])
    state = said["state"] - said["kind"] - said["what"]
    return bool(
        (said["is"] and (deed or not said["wish"]))
        or (state and not said["wish"] - ({"weak"} if deed else set()))
        or any(map(_RE["tells"].fullmatch, unknown))
    )


def _filled(said: dict[str, set[str]], *, whole: bool) -> Filled:
    """Return the slots of a command, from all phrases together.

    Implied slots are filled only if the `whole` sentence is known: an unknown word may contradict.
    """
    _join_phrases(said)
    if not whole and said["kind"] & {"clip", "cut", "open", "close"}:
        said.pop("which", set())  # "on the left" may belong to an unknown word
    _place_sides(said)
    _place_directions(said)
    if whole:
        _place_bare_sides(said)
        _infer_kind(said)
    return {slot: said[slot] for slot in _OF_COMMANDS if said[slot]}


def _join_phrases(said: dict[str, set[str]]) -> None:
    """Combine phrases that mean something together that neither means alone."""
    _make_orders(said)
    if said["blades"]:
        said["arm"] |= {"right"}
    if len(said["kind"]) > 1 or said["arm"] | said["tube"] | said["what"] | said["which"]:
        said["kind"] -= {"resume", "repeat"}  # go on and ...
    _join_grips(said)
    _join_cuts(said)
    _join_clips(said)


def _join_grips(said: dict[str, set[str]]) -> None:
    """Tell grabbing the gallbladder from closing the jaws."""
    if said["organ"] and (said["hold"] or said["kind"] == {"close"}):
        said["kind"] = {"grab"}
    if not said["organ"] and said["kind"] & {"open", "close"}:
        said["kind"] -= {"grab"}
    if "let go" in said["kind"]:
        said["kind"] -= {"open"}


def _join_cuts(said: dict[str, set[str]]) -> None:
    """Tell cutting from going back from the cut and from going to its position."""
    if said["from_cut"] and said["kind"] <= {"go_back"}:
        said["kind"] = {"go_back_from_cut"}
    if "cut" in said["kind"] and said["ready"] | said["position"]:
        said["kind"] |= {"cut_position"}
    if "cut_position" in said["kind"]:
        said["kind"] -= {"cut"}


def _join_clips(said: dict[str, set[str]]) -> None:
    """Read closing a tube as clipping it, and "two" as the second clip if a tube is named."""
    if said["what"] & ORDINALS or ("clip" in said["kind"] and said["tube"] | said["what"]):
        said["kind"] -= {"close"}
    of_clips = said["kind"] & {"clip", "go_back"} or (said["tube"] and not said["kind"])
    if of_clips and not said["what"]:
        said["what"] |= said["number"]


def _make_orders(said: dict[str, set[str]]) -> None:
    """Read a state ("clipped") as an order, except in going back, where it is past."""
    state = said.pop("state", set())
    if "go_back" in said["kind"] and state | said["is"] | said["after"] | said["from"]:
        said["from_cut"] |= (state | said["kind"]) & {"cut"}
        said["kind"] -= {"clip", "cut", "open", "close"}
    else:
        said["what"] |= state & DIRECTIONS
        said["kind"] |= state - DIRECTIONS


def _of_tube(said: dict[str, set[str]]) -> bool:
    return bool(said["kind"] & TUBE_KINDS or said["what"] & ORDINALS)


def _place_sides(said: dict[str, set[str]]) -> None:
    """Assign "the left one" to the sentence's tube or arm; with an arm, "left" is a direction."""
    of_arm = "what" if said["arm"] and not said["kind"] & {"open", "close"} else "arm"
    said["tube" if _of_tube(said) else of_arm] |= said.pop("which", set())
    if _of_tube(said) and not said["tube"]:  # a clip is put to the left
        said["tube"] = said["what"] & {"left", "right"}
        said["what"] -= said["tube"]
    if said["arm"] and not said["kind"] & TUBE_KINDS:
        said["what"] |= said.pop("side", set())


def _place_directions(said: dict[str, set[str]]) -> None:
    """Read directions: "up" but not in "open up", "in" but not in "higher in there"."""
    if not said["kind"] | said["what"] & ORDINALS:
        said["what"] |= said["particle"]
        said["what"] |= set() if said["what"] & DIRECTIONS else said["preposition"]


def _place_bare_sides(said: dict[str, set[str]]) -> None:
    if _of_tube(said) and not said["tube"]:
        said["tube"] |= said["side"]
    elif said["kind"] & {"open", "close", "let go"} or said["what"] & DIRECTIONS:
        said["arm"] |= said["side"]
    else:
        said["what"] |= said["side"]


def _infer_kind(said: dict[str, set[str]]) -> None:
    """Infer the kind of command where the sentence names only its object or its manner."""
    elsewhere = said["tube"] | said["what"] - {"towards"}
    if said["arm"] and said["kind"] == {"go_back"} and not elsewhere:
        said["kind"], said["what"] = set(), {"towards"}
    if said["arm"] and not said["organ"] and said["kind"] == {"let go"}:
        said["kind"] = {"open"}
    if said["what"] & ORDINALS and not said["kind"] | said["motion"]:
        said["kind"] = {"clip"}
    if said["blades"] and said["tube"] and not said["kind"] | said["what"]:
        said["kind"] = {"cut_position"}
    if said["what"] & DIRECTIONS:
        said["kind"] |= {"move"}
    if said["organ"] and said["arm"] and not said["kind"]:
        said["kind"] = {"grab"}
    if not said["kind"] | said["what"] | said["carry"]:
        said["kind"] = said["alone"] | ({"pause"} if said["hold"] else set())


def openness(parsed: Parse) -> Openness:
    """Return whether the sentence leaves slots open, or only has unknown words."""
    return "unknown words" if spelt_out(parsed.filled) else "open slots"


def may_be_filled(parsed: Parse, command: Command) -> bool:
    """Return whether a guessed command may fill slots that unknown words leave open.

    A word about the run may not be guessed: an unknown word may name what to resume or let go.
    """
    if command.word:
        return False
    open_to_others = parsed.unknown and not parsed.refusal and not contradicts(parsed.filled)
    return bool(open_to_others) and named_outright(command, parsed.filled)
