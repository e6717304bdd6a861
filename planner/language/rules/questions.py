"""The questions that the robot answers: the patterns of questions.toml, in their order."""

from __future__ import annotations

import re
from typing import Literal, get_args

from planner.language.rules.phrase_lists import phrase_lists, whole_words
from planner.language.rules.plain_letters import in_plain_letters

Question = Literal["distance", "clips", "wrong", "sure", "next", "why", "on", "doing"]
QUESTIONS: tuple[Question, ...] = get_args(Question)
_BEFORE = re.compile(
    r"^((please|ok|okay|so|and|now|um|uh|hey|robot|calot|sorry|just|say|well|quick question) )*"
)
_REQUESTS = re.compile(
    r"\b((?<!what )(?<!how )(?<!where )(?<!which )(can|could|would|will|won't|may) (you|we|i)"
    r"(?!( please)?( (give|tell|explain|confirm|say|ask|let (me|us) know|remind|show me (what|how)"
    r"|be so kind as to tell|bet|swear)|$))"
    r"|how about|why (don't|not))\b"
)


def question_in(text: str) -> Question | None:
    """Return what a sentence asks; None if it asks nothing that is answered."""
    words = in_plain_letters(text)
    lists = phrase_lists("questions")
    begins = _BEFORE.sub("", words)
    asks = whole_words(lists["asks"]["beginnings"]).match(begins) or text.rstrip().endswith("?")
    if not asks or _REQUESTS.search(words):
        return None
    kinds = lists["questions"]
    return next((kind for kind in QUESTIONS if whole_words(kinds[kind]).search(words)), None)
