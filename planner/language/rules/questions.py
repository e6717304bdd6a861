"""The questions that the robot answers: the patterns of questions.toml, in their order."""

from __future__ import annotations

import re
from typing import Literal, cast, get_args

from planner.language.rules.phrase_lists import phrase_lists, whole_words
from planner.language.rules.plain_letters import in_plain_letters

Question = Literal[
    "why", "left", "forbidden", "safe", "held", "distance", "clips", "wrong", "cut", "sure",
    "next", "where", "which", "on", "doing",
]  # fmt: skip
Thing = Literal[
    "common bile duct", "hepatic artery", "left tube", "right tube", "duct", "artery",
    "gallbladder", "clip", "left tool", "right tool",
]  # fmt: skip
QUESTIONS: tuple[Question, ...] = get_args(Question)
_BEFORE = re.compile(
    r"^((please|ok|okay|so|and|now|um|uh|hey|robot|calot|sorry|just|say|well|quick question) )*"
)
_STATES = re.compile(r"(?:you|u|we)(?: are|'re| may| must| can| will)? (?:not|never)\b")
_REQUESTS = re.compile(
    r"\b((?<!what )(?<!how )(?<!where )(?<!which )(?<!when )(can|could|would|will|won't|may)"
    r" (you|we|i)"
    r"(?!( please)?( (give|tell|explain|confirm|say|ask|let (me|us) know|remind|show me (what|how)"
    r"|be so kind as to tell|point|say|be|see|safely|without|bet|swear|safely)|$))"
    r"|how about|why (don't|not))\b"
)


def question_in(text: str) -> Question | None:
    """Return what a sentence asks; None if it asks nothing that is answered."""
    words = in_plain_letters(text)
    lists = phrase_lists("questions")
    begins = _BEFORE.sub("", words)
    asks = whole_words(lists["asks"]["beginnings"]).match(begins) or text.rstrip().endswith("?")
    if (
        not asks
        or (_STATES.match(words) and not text.rstrip().endswith("?"))
        or _REQUESTS.search(words)
    ):
        return None
    kinds = lists["questions"]
    return next((kind for kind in QUESTIONS if whole_words(kinds[kind]).search(words)), None)


def thing_in(text: str) -> Thing | None:
    """Return what a sentence is about: a structure, a tool or a clip; None if it names none."""
    words, things = in_plain_letters(text), phrase_lists("questions")["things"]
    named = (name for name, phrases in things.items() if whole_words(phrases).search(words))
    return cast("Thing | None", next(named, None))
