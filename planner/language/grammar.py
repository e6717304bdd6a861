"""What the words say outright: the slots that they fill, or why nothing is to be done."""

from __future__ import annotations

import re
import unicodedata
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from planner.command import Command
from planner.language.lexicon import LEXICON, LONGEST, Sense
from planner.language.slots import (
    DIRECTIONS,
    OPPOSITE,
    ORDINALS,
    TUBE_KINDS,
    Filled,
    contradicts,
    names_closed_slots,
)

_NUMBER = r"(\d+([.,]\d+)?|an?|half an?|one|two|three|four|five|ten|a few|a couple of|some)"
_AMOUNT = re.compile(rf"\b{_NUMBER}\s*(mm|cm|(milli|centi)met(er|re)s?)\b")
_OPENING = re.compile(
    r"^(right|good|great|perfect|nice|fine|excellent|all ?right|well done)[,.!;:]+"
)
_DO_NOT_MOVE = re.compile(r"^(please )?(do not|don't|dont) move( please| now| anything)?$")
_NOT_ENOUGH = re.compile(r"\b(is not|isn't|are not|aren't|not)\b(.*)\benough\b")
_QUESTION = re.compile(
    r"^(what|what's|why|who|who's|whose|where|where's|which|how|how's|is|are|was|were|am|does|did"
    r"|has|have|had|should|shall|can|could|would|will|may|must|do (you|we|i|they))\b"
)
_REQUEST = re.compile(r"^(please )?((can|could|would|will) you|(can|could) (we|i) (have|get))\b")
_BACK_AFTER = re.compile(r"\b(back|back off|out|return|retreat|withdraw) after\b")
_STOP = re.compile(r"^((no|please|hey|robot|calot|just) )*(stop|halt|freeze|abort)\b")
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


def normalised(text: str) -> str:
    """Lower case, plain letters, single spaces; amounts and their units go.

    What begins with "stop" is "stop", whatever follows: to stop in vain does no harm.
    """
    plain = unicodedata.normalize("NFKC", text).lower().replace("’", "'").strip()
    plain = re.sub(r"[^a-z0-9' ]+", " ", _AMOUNT.sub(" ", _OPENING.sub("", plain)))
    plain = _BACK_AFTER.sub(r"\1 from", _NOT_ENOUGH.sub(r"\2", " ".join(plain.split())))
    return "stop" if _STOP.match(plain) or _DO_NOT_MOVE.match(plain) else plain


def parse(text: str) -> Parse:
    """The slots that a sentence fills, the words it leaves open, and what speaks against it."""
    words = normalised(text)
    asked_for = _REQUEST.sub("", words)
    senses = list(_senses(asked_for.split()))
    said: dict[str, set[str]] = {}
    for sense in senses:
        if isinstance(sense, Sense) and sense.slot != "filler":
            said.setdefault(sense.slot, set()).add(sense.value)
    refusal = min(said.get("refusal", {""}))
    if "is" in said and "too" not in said:
        refusal = refusal or "it tells how things are"
    if words == asked_for and (_QUESTION.match(words) or text.rstrip().endswith("?")):
        refusal = "it is a question"
    if "stop" in said.get("kind", ()):  # whatever else is said
        return Parse(filled={"kind": {"stop"}}, refusal=refusal)
    unknown = tuple(sense for sense in senses if isinstance(sense, str))
    return Parse(filled=_filled(said, whole=not unknown), unknown=unknown, refusal=refusal)


def _senses(words: list[str]) -> Iterator[Sense | str]:
    """Of the longest phrases, from the first word on; a word that is not known as it is."""
    k = 0
    while k < len(words):
        n, sense = _longest(words[k : k + LONGEST])
        yield sense
        k += n


def _longest(words: list[str]) -> tuple[int, Sense | str]:
    for n in range(len(words), 0, -1):
        if sense := LEXICON.get(" ".join(words[:n])):
            return n, sense
    return 1, LEXICON.get(_spelt(words[0]), words[0])


@cache
def _known_words() -> frozenset[str]:
    return frozenset(word for phrase in LEXICON for word in phrase.split() if len(word) > 3)


def _spelt(word: str) -> str:
    """The known word from which one slip of the finger leads to this; or the word itself."""
    if len(word) < 4:
        return word
    near = {slip for slip in _slips(word) if slip in _known_words() and slip[0] == word[0]}
    return near.pop() if len(near) == 1 and not _inflects(word, *near) else word


def _inflects(word: str, known: str) -> bool:
    """Whether it is another form of it, as "moved" is of "move", and means something else."""
    return word.startswith(known[:-1]) and word.endswith(("s", "d", "ed", "er", "y"))


def _slips(word: str) -> Iterator[str]:
    """A letter left out, swapped, changed or put in."""
    letters = "abcdefghijklmnopqrstuvwxyz"
    for k in range(len(word) + 1):
        head, tail = word[:k], word[k:]
        yield head + tail[1:]
        yield head + tail[1:2] + tail[:1] + tail[2:]
        for letter in letters:
            yield head + letter + tail[1:]
            yield head + letter + tail


def _filled(said: dict[str, set[str]], *, whole: bool) -> Filled:
    """The slots of a command, from what the phrases say together.

    What is implied only is filled when the `whole` sentence is known: a word that is not may say
    otherwise.
    """
    said = defaultdict(set, {slot: set(values) for slot, values in said.items()})
    _join_phrases(said)
    _place_sides(said)
    if whole:
        _place_bare_sides(said)
        _infer_kind(said)
    if said["too"]:
        for slot in ("kind", "what"):
            said[slot] = {OPPOSITE.get(value, value) for value in said[slot]}
    return {slot: said[slot] for slot in _OF_COMMANDS if said[slot]}


def _join_phrases(said: dict[str, set[str]]) -> None:
    """Going back from the cut, and the position for it, are not cutting."""
    if said["from_cut"] and "go_back" in said["kind"]:
        said["kind"] = {"go_back_from_cut"}
    if "cut_position" in said["kind"]:
        said["kind"] -= {"cut"}


def _of_tube(said: dict[str, set[str]]) -> bool:
    return bool(said["kind"] & TUBE_KINDS or said["what"] & ORDINALS) and not said["arm"]


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
    if (
        said["arm"]
        and said["kind"] == {"go_back"}
        and not said["tube"] | said["what"] - {"towards"}
    ):
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
    return bool(open_to_others) and names_closed_slots(command, parsed.filled)
