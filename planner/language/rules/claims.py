"""From a sentence to what its speaker takes for so: "the duct is cut, go back"; claims.toml."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import cast

from planner.language.rules.phrase_search import in_plain_letters, phrase_lists, whole_words
from planner.language.rules.questions import question_in
from planner.person.premises import Claim, Claimed, Where

_CLAUSE = re.compile(r"[,;.!?:]|\b(?:so|then)\b")
_COUNTS = {"one": 1, "two": 2, "three": 3, "1": 1, "2": 2, "3": 3}
_ABOUT_WHY = ("why", "doing", "next")  # questions that take something for so, and do not ask it


def claims_in(text: str) -> tuple[Claim, ...]:
    """Return what an English sentence takes for done or so, of tubes, clips and the gallbladder.

    Who asks whether it is so, denies it, or says "if" or "once" it is, takes nothing for so.
    """
    if (asked := question_in(text)) is not None and asked not in _ABOUT_WHY:
        return ()
    if asked is None and text.rstrip().endswith("?"):
        return ()
    clauses = (in_plain_letters(clause) for clause in _CLAUSE.split(text.lower()))
    return tuple(dict.fromkeys(claim for words in clauses for claim in _claims_of(words)))


def without_claims(text: str) -> str:
    """Return what a sentence says besides the clauses that take something for so, if any does."""
    clauses = [clause.strip() for clause in _CLAUSE.split(text)]
    others = [c for c in clauses if not any(_claims_of(in_plain_letters(c)))]
    return ", ".join(filter(None, others)) if len(others) < len(clauses) else text


def _claims_of(words: str) -> Iterator[Claim]:
    lists = phrase_lists("claims")
    if whole_words(lists["unless"]["words"]).search(words):
        return
    for claimed, patterns in _patterns().items():
        if found := patterns.search(words):
            many = found.groupdict().get("many")
            yield Claim(claimed=claimed, on=_on(words), n=_COUNTS.get(many or ""))
            return


def _on(words: str) -> Where:
    """Return which tube is named; "" for the one at hand."""
    things = phrase_lists("claims")["tubes"]
    return cast("Where", next((k for k, ps in things.items() if whole_words(ps).search(words)), ""))


@cache
def _patterns() -> dict[Claimed, re.Pattern[str]]:
    """Return what finds each kind of claim in a clause, in the order of the file."""
    lists = phrase_lists("claims")
    words = {name: "|".join(phrases) for name, phrases in lists["words"].items()}
    patterns = {
        name: re.compile("|".join(rf"(?:\b{p.format_map(words)}\b)" for p in phrases))
        for name, phrases in lists["claims"].items()
    }
    return cast("dict[Claimed, re.Pattern[str]]", patterns)
