"""Questions in German, French, Spanish, Italian and Chinese; foreign_questions.toml lists them."""

from __future__ import annotations

import re
from functools import cache

from planner.language.rules.phrase_lists import phrase_lists, whole_words
from planner.language.rules.plain_letters import in_plain_letters
from planner.language.rules.questions import QUESTIONS, Question
from planner.language.rules.warning import warns

_CHINESE = re.compile(r"[\u4e00-\u9fff]")


def foreign_question_in(text: str) -> Question | None:
    """Return what a text in another language asks calmly; None for English, or a warning."""
    if "!" in text:
        return None
    words, lists = in_plain_letters(text), phrase_lists("foreign_questions")
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
