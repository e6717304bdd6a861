"""What the words say outright: the slots that they fill, or why nothing is to be done."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from planner.command import Command
from planner.language.lexicon import Sense
from planner.language.phrases import normalised, senses
from planner.language.slots import (
    DIRECTIONS,
    OPPOSITE,
    ORDINALS,
    TUBE_KINDS,
    Filled,
    contradicts,
    named_outright,
)

_QUESTION = re.compile(
    r"^(what|what's|why|who|who's|whose|where|where's|which|how|how's|is|are|was|were|am|does|did"
    r"|has|have|had|should|shall|can|could|would|will|may|must|do (you|we|i|they))\b"
)
_REQUEST = re.compile(r"^(please )?((can|could|would|will) you|(can|could) (we|i) (have|get))\b")
_TELLS = re.compile(r"\w{2,}(ed|[^s']s)")  # slipped, slips: no order is worded so
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
    if "stop" in said["kind"]:  # whatever else is said
        return Parse(filled={"kind": {"stop"}}, refusal=refusal)
    return Parse(filled=_filled(said, whole=not unknown), unknown=unknown, refusal=refusal)


def _said(found: Iterable[Sense]) -> dict[str, set[str]]:
    """Values by slot; what one has too much of is turned round."""
    said, too = defaultdict(set), False
    for slot, value in found:
        turns = too and slot in ("kind", "what", "side")
        said[slot].add(OPPOSITE.get(value, value) if turns else value)
        too = slot == "too" or (too and not turns)
    return said


def _refusal(said: dict[str, set[str]], unknown: tuple[str, ...]) -> str:
    tells = (said["is"] and not said["too"]) or any(map(_TELLS.fullmatch, unknown))
    return min(said["refusal"], default="it tells how things are" if tells else "")


def _filled(said: dict[str, set[str]], *, whole: bool) -> Filled:
    """The slots of a command, from what the phrases say together.

    What is implied only is filled when the `whole` sentence is known: a word that is not may say
    otherwise.
    """
    _join_phrases(said)
    _place_sides(said)
    if whole:
        _place_bare_sides(said)
        _infer_kind(said)
    return {slot: said[slot] for slot in _OF_COMMANDS if said[slot]}


def _join_phrases(said: dict[str, set[str]]) -> None:
    """Going back from the cut, and the position for it, are not cutting; holding may be waiting."""
    if said["hold"] and said["organ"]:
        said["kind"] |= {"grab"}
    if said["from_cut"] and "go_back" in said["kind"]:
        said["kind"] = {"go_back_from_cut"}
    if "cut_position" in said["kind"]:
        said["kind"] -= {"cut"}


def _of_tube(said: dict[str, set[str]]) -> bool:
    return bool(said["kind"] & TUBE_KINDS or said["what"] & ORDINALS)


def _place_sides(said: dict[str, set[str]]) -> None:
    """Sides of "the left one" belong to what the rest is about; with an arm, "left" is where to."""
    said["tube" if _of_tube(said) else "arm"] |= said.pop("which", set())
    if said["arm"] and not said["kind"] & TUBE_KINDS:
        said["what"] |= said.pop("side", set())


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
    if said["arm"] and said["kind"] == {"let go"}:
        said["kind"] = {"open"}
    if said["what"] & ORDINALS and not said["kind"] | said["motion"]:
        said["kind"] = {"clip"}
    if said["what"] & DIRECTIONS:
        said["kind"] |= {"move"}
    if not said["kind"] | said["what"]:
        said["kind"] = said["alone"]


def may_be_filled(parsed: Parse, command: Command) -> bool:
    """Whether a command may be taken for what is left open: by unknown words, not by too few."""
    open_to_others = parsed.unknown and not parsed.refusal and not contradicts(parsed.filled)
    return bool(open_to_others) and named_outright(command, parsed.filled)
