"""What the words say outright: the slots that they fill, or why nothing is to be done."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from planner.command import Command
from planner.correction import OPPOSITE
from planner.language.lexicon import Sense
from planner.language.phrases import normalised, senses
from planner.language.slots import (
    DIRECTIONS,
    ORDINALS,
    TUBE_KINDS,
    Filled,
    contradicts,
    named_outright,
    spelt_out,
)

_QUESTION = re.compile(
    r"^(what|what's|why|who|who's|whose|where|where's|which|how|how's|is|are|was|were|am|does|did"
    r"|has|have|had|should|shall|can|could|would|will|may|must|do (you|we|i|they))\b"
)
_REQUEST = re.compile(
    r"^((please|ok|okay|so|and|now|um|uh|hey|robot|calot) )*((can|could|would|will) you"
    r"|(can|could|may) (we|i) (please |just )*(have|get|put|ask you (to|for)|trouble you (to|for))"
    r"|have (?=(left|right|both|grasper|scissors|clip applier)\b"
    r".* (open|close|take|grab|move|come)\b)"
    r"|(how|what) about|why (don't|not)( you)?|are you able to"
    r"|(can|could) (?=(left|right|robot|grasper|scissors|clip applier)"
    r"( \w+){0,2} (come|go|move|drop|sit|get)\b))\b"
)
_TELLS = re.compile(r"\w{2,}(ed|[^s']s)")  # slipped, slips: no order is worded so
_TURNED = ("kind", "what", "side", "particle", "preposition")  # by "too"
Openness = Literal["unknown words", "open slots"]
_DENIED = "it says what not to do"
_OF_COMMANDS = ("kind", "arm", "tube", "organ", "what")


@dataclass(frozen=True, kw_only=True)
class Parse:
    """What the words of a sentence say.

    Attributes:
        filled: The slots.
        unknown: Words that nothing is known about.
        refusal: Why nothing is to be done, in words; empty when there is no reason.
    """

    filled: Filled
    unknown: tuple[str, ...] = ()
    refusal: str = ""


def parse(text: str) -> Parse:
    """The slots that a sentence fills, the words it leaves open, and what speaks against it."""
    words = normalised(text)
    asked_for = _REQUEST.sub("", words)
    found = list(senses(asked_for.split()))
    unknown = tuple(one for one in found if isinstance(one, str))
    said = _said(one for one in found if isinstance(one, Sense))
    asks = words == asked_for and (_QUESTION.match(words) or text.rstrip().endswith("?"))
    refusal = "it is a question" if asks else _refusal(said, unknown)
    if _DENIED not in said["refusal"] and not asks:
        if "stop" in said["kind"]:  # whatever else is said
            return Parse(filled={"kind": {"stop"}})
        if said["kind"] == {"pause"}:
            refusal = ""
    return Parse(filled=_filled(said, whole=not unknown), unknown=unknown, refusal=refusal)


def _said(found: Iterable[Sense]) -> dict[str, set[str]]:
    """Values by slot; what one has too much of is turned round."""
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
    """Why nothing is to be done, if so."""
    goes_back = "go_back" in said["kind"]
    if said["after"] and not goes_back:
        return "it sets a condition or a time"
    too_much = said["too"] and not unknown and not said["kind"] & {"clip", "cut"}
    tells = not (goes_back or too_much) and _tells(said, unknown)
    return min(said["refusal"], default="it tells how things are" if tells else "")


def _tells(said: dict[str, set[str]], unknown: tuple[str, ...]) -> bool:
    """Whether something is described; a wish describes too, but a clip or a cut must be ordered."""
    deed = {"clip", "cut"} & (said["kind"] | said["state"])
    state = said["state"] - said["kind"] - said["what"]
    return bool(
        (said["is"] and (deed or not said["wish"]))
        or (state and not said["wish"] - ({"weak"} if deed else set()))
        or any(map(_TELLS.fullmatch, unknown))
    )


def _filled(said: dict[str, set[str]], *, whole: bool) -> Filled:
    """The slots of a command, from what the phrases say together.

    What is implied only is filled when the `whole` sentence is known: a word that is not may say
    otherwise.
    """
    _join_phrases(said)
    if not whole and said["kind"] & {"clip", "cut", "open", "close"}:
        said.pop("which", set())  # "on the left" may be said of what is unknown
    _place_sides(said)
    _place_directions(said)
    if whole:
        _place_bare_sides(said)
        _infer_kind(said)
    return {slot: said[slot] for slot in _OF_COMMANDS if said[slot]}


def _join_phrases(said: dict[str, set[str]]) -> None:
    """What two phrases say together that neither says alone."""
    _make_orders(said)
    if said["blades"]:
        said["arm"] |= {"right"}
    if len(said["kind"]) > 1 or said["arm"] | said["tube"] | said["what"] | said["which"]:
        said["kind"] -= {"resume", "repeat"}  # go on and ...
    _join_grips(said)
    _join_cuts(said)
    _join_clips(said)


def _join_grips(said: dict[str, set[str]]) -> None:
    """The gallbladder is held and closed on; a tighter grip of the jaws grabs nothing."""
    if said["organ"] and (said["hold"] or said["kind"] == {"close"}):
        said["kind"] = {"grab"}
    if not said["organ"] and said["kind"] & {"open", "close"}:
        said["kind"] -= {"grab"}
    if "let go" in said["kind"]:
        said["kind"] -= {"open"}


def _join_cuts(said: dict[str, set[str]]) -> None:
    """Going back from the cut, and the position for it, are not cutting."""
    if said["from_cut"] and said["kind"] <= {"go_back"}:
        said["kind"] = {"go_back_from_cut"}
    if "cut" in said["kind"] and said["ready"] | said["position"]:
        said["kind"] |= {"cut_position"}
    if "cut_position" in said["kind"]:
        said["kind"] -= {"cut"}


def _join_clips(said: dict[str, set[str]]) -> None:
    """Tubes are closed with clips; "two" counts clips where a tube is named."""
    if said["what"] & ORDINALS or ("clip" in said["kind"] and said["tube"] | said["what"]):
        said["kind"] -= {"close"}
    of_clips = said["kind"] & {"clip", "go_back"} or (said["tube"] and not said["kind"])
    if of_clips and not said["what"]:
        said["what"] |= said["number"]


def _make_orders(said: dict[str, set[str]]) -> None:
    """What is to be "clipped" is to be clipped; what one goes back from has been."""
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
    """Sides of "the left one" belong to what the rest is about; with an arm, "left" is where to."""
    of_arm = "what" if said["arm"] and not said["kind"] & {"open", "close"} else "arm"
    said["tube" if _of_tube(said) else of_arm] |= said.pop("which", set())
    if _of_tube(said) and not said["tube"]:  # a clip is put to the left
        said["tube"] = said["what"] & {"left", "right"}
        said["what"] -= said["tube"]
    if said["arm"] and not said["kind"] & TUBE_KINDS:
        said["what"] |= said.pop("side", set())


def _place_directions(said: dict[str, set[str]]) -> None:
    """Where to: "up" but not in "open up", "in" but not in "higher in there"."""
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
    """What is done, where only how or to what is said."""
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
    """Whether unknown words leave slots open, or are merely unknown."""
    return "unknown words" if spelt_out(parsed.filled) else "open slots"


def may_be_filled(parsed: Parse, command: Command) -> bool:
    """Whether a command may be taken for what is left open: by unknown words, not by too few.

    A word about the run may not: what is unknown may be what else is to be resumed, or let go.
    """
    if command.word:
        return False
    open_to_others = parsed.unknown and not parsed.refusal and not contradicts(parsed.filled)
    return bool(open_to_others) and named_outright(command, parsed.filled)
