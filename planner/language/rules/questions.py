"""Recognise the questions that the robot answers, in English and five other languages.

The patterns are in questions.toml, in their order, and in foreign_questions.toml: German, French,
Spanish, Italian and Chinese.
"""

from __future__ import annotations

import re
from functools import cache
from typing import Literal, cast, get_args

from planner.language.rules.phrase_search import (
    in_plain_letters,
    patterns,
    phrase_lists,
    whole_words,
)
from planner.language.rules.spelling import with_artery
from planner.language.rules.warning import warns

Question = Literal[
    "why", "left", "forbidden", "safe", "held", "distance", "clips", "wrong", "cut", "sure",
    "next", "where", "which", "on", "doing",
]  # fmt: skip
Thing = Literal[
    "common bile duct", "hepatic artery", "third tube", "left tube", "right tube", "duct", "artery",
    "gallbladder", "clip", "left tool", "right tool",
]  # fmt: skip
QUESTIONS: tuple[Question, ...] = get_args(Question)
_RE = patterns("questions")


def question_in(text: str) -> Question | None:
    """Return what a sentence asks; None if it asks nothing that is answered."""
    words = in_plain_letters(text)
    lists = phrase_lists("questions")
    begins = _RE["before"].sub("", words)
    asks = whole_words(lists["asks"]["beginnings"]).match(begins) or text.rstrip().endswith("?")
    if not asks or (_RE["states"].match(begins) and not text.rstrip().endswith("?")):
        return None
    if asks_plainly(text):
        return "which"
    if _RE["requests"].search(words):
        return None
    if whole_words(lists["first"]["which"]).search(words):
        return "which"
    kinds, of_artery = lists["questions"], with_artery(words)
    said = {kind: words if kind == "which" else of_artery for kind in QUESTIONS}
    return next((kind for kind in QUESTIONS if whole_words(kinds[kind]).search(said[kind])), None)


def asks_plainly(text: str) -> bool:
    """Return whether a whole sentence asks for the tubes' number, a tube's size, or its clips."""
    words = _RE["before"].sub("", in_plain_letters(text)).strip()
    return bool(whole_words(phrase_lists("questions")["plain"]["which"]).fullmatch(words))


def thing_in(text: str) -> Thing | None:
    """Return what a sentence is about: a structure, a tool or a clip; None if it names none."""
    words, things = in_plain_letters(text), phrase_lists("questions")["things"]
    named = (name for name, phrases in things.items() if whole_words(phrases).search(words))
    return cast("Thing | None", next(named, None))


_HOLDS = re.compile(r"\bh(?:ä|a\u0308)lt\b", re.IGNORECASE)  # "halt" is a warning
_CHINESE = re.compile(r"[\u4e00-\u9fff]")


def foreign_question_in(text: str) -> Question | None:
    """Return what a text in another language asks calmly; None for English, or a warning."""
    if "!" in text:
        return None
    words = in_plain_letters(_HOLDS.sub("haelt", text))
    lists = phrase_lists("foreign_questions")
    if _CHINESE.search(words):
        table, calm = lists["chinese"], re.compile("|".join(lists["calm"]["chinese"]))
        asks = text.rstrip().endswith("?") or re.search("|".join(lists["asks"]["chinese"]), words)
    else:
        table, calm = lists["questions"], whole_words(lists["calm"]["words"])
        begins = whole_words(lists["asks"]["beginnings"]).match(words)
        asks = text.rstrip().endswith("?") or begins
    if not asks or warns(calm.sub(" ", words)):
        return None
    patterns = _patterns(table is lists["chinese"])
    return next((kind for kind in QUESTIONS if patterns[kind].search(words)), None)


@cache
def _patterns(chinese: bool) -> dict[Question, re.Pattern[str]]:
    lists = phrase_lists("foreign_questions")
    if chinese:
        return {kind: re.compile("|".join(lists["chinese"][kind])) for kind in QUESTIONS}
    return {kind: whole_words(lists["questions"][kind]) for kind in QUESTIONS}
