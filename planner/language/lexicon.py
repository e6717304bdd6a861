"""The words that surgeons use (lexicon.toml), each with the slot that it fills."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import NamedTuple

from planner.language.rules.phrase_search import phrase_lists


class Meaning(NamedTuple):
    """The meaning of a phrase.

    Attributes:
        slot: A table of lexicon.toml; for a side without a noun "which", or "side" if it may
            also be a direction.
        value: Of the slot.
    """

    slot: str
    value: str


_BEFORE = ("", "on ", "to ", "onto ", "at ", "of ", "for ", "with ")
_BETWEEN = ("", "hand ", "side ", "hand side ", "handed ", "sided ", "robot ", "robotic ")
_SIDES = ("left", "right")
_NOUNS = phrase_lists("nouns")["nouns"]
_ARTICLES = ("the", "your")
_VERBS = ("kind", "motion", "moves", "carry")
_DOUBLES = re.compile(r"(qu)?[^aeiou]*[aeiou][bdgmnprt]")


def without_articles(text: str) -> str:
    """Return the words without articles, with single spaces between them."""
    return " ".join(word for word in text.split() if word not in _ARTICLES)


def _phrases() -> Iterator[tuple[str, str, str]]:
    """Yield table, key and phrase of every entry."""
    tables = tomllib.loads(Path(__file__).with_name("lexicon.toml").read_text("utf-8"))
    for table, values in tables.items():
        for value, phrases in values.items():
            yield from ((table, value, without_articles(one)) for one in phrases.split(","))


def _listed() -> dict[str, Meaning]:
    found, verbs = {}, {}
    for table, value, phrase in _phrases():
        found[phrase] = Meaning("what" if table == "moves" else table, value)
        if table in _VERBS:
            verbs[phrase] = found[phrase]
    return _inflected(verbs) | found


def _inflected(verbs: Mapping[str, Meaning]) -> dict[str, Meaning]:
    """Return other verb forms: "clipping" means the same as "clip"; "clipped" is a state."""
    found: dict[str, Meaning] = {}
    for phrase, sense in verbs.items():
        verb, _, rest = phrase.partition(" ")
        stem = verb + verb[-1] if _DOUBLES.fullmatch(verb) else verb.removesuffix("e")
        found[f"{stem}ing {rest}".strip()] = sense
        found[f"{stem}ed {rest}".strip()] = Meaning("state", sense.value)
    return found


def _sided() -> dict[str, Meaning]:
    """Return phrases for sides of arms and tubes; "to the left arm" is not a direction."""
    of_noun = {
        f"{before}{side} {between}{noun}": Meaning(slot, side)
        for slot, nouns in _NOUNS.items()
        for before, side, between, noun in product(_BEFORE, _SIDES, _BETWEEN, nouns)
    }
    on = {f"{before} {side}": Meaning("which", side) for before in ("on", "at") for side in _SIDES}
    both = {f"both {noun}": Meaning("arm", "both") for noun in _NOUNS["arm"]}
    heard = {
        f"{wrong} {n}": Meaning(slot, "right")
        for wrong in ("write", "rite", "wright")
        for slot, ns in _NOUNS.items()
        for n in ns
    }
    bare = {side: Meaning("side", side) for side in _SIDES}
    return of_noun | on | both | heard | bare


LEXICON: dict[str, Meaning] = _sided() | _listed()
LONGEST = max(len(phrase.split()) for phrase in LEXICON)
