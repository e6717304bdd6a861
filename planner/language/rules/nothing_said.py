"""Does a text hold no word to anybody? A recogniser's names of sounds, stock phrases, fillers."""

from __future__ import annotations

import re
from functools import cache

from planner.language.rules.phrase_search import in_plain_letters, longest_first, phrase_lists
from planner.language.rules.warning import warns

_SOUND = re.compile(r"\s*[\[(*<♪♫{(【][^\])*>♪♫})】]*[\])*>♪♫})】]\s*")

_FRIGHT = re.compile(r"\b(?:uh|oh|ah|eh) (?:oh|ah|no)\b|^(?:oh|ah)$")


def says_nothing(text: str) -> bool:
    """Return whether a text has no word, only names sounds, or is a stock phrase or a filler.

    What is empty, or asks, is not of these; nor is a sound's name that warns: "(bleeding)".
    """
    words = in_plain_letters(text)
    if not text.strip():
        return False
    sounds, stock, fillers = _patterns()
    if not words or sounds.fullmatch(words) or stock.fullmatch(words):
        return "?" not in text or not words
    if _SOUND.fullmatch(text) and not warns(text):
        return True
    if _in_chinese(words):
        return "?" not in text
    return "?" not in text and bool(fillers.fullmatch(words)) and not _FRIGHT.search(words)


def _in_chinese(words: str) -> bool:
    lists = phrase_lists("nothing_said")
    stock, rest = lists["stock"]["chinese"], words.replace(" ", "")
    if any(signs in rest for signs in stock) and not warns(rest.replace("不吝", "")):
        return True
    fillers = sorted(lists["fillers"]["chinese"], key=len, reverse=True)
    for signs in fillers:
        rest = rest.replace(signs, "")
    return not rest


@cache
def _patterns() -> tuple[re.Pattern[str], re.Pattern[str], re.Pattern[str]]:
    """Return what matches, as a whole, names of sounds, stock phrases and fillers."""
    lists = phrase_lists("nothing_said")
    sounds, stock, fillers = (
        re.compile(rf"(?:(?:{longest_first(lists[table][key])})(?: |$))++")
        for table, key in (("sounds", "words"), ("stock", "phrases"), ("fillers", "words"))
    )
    return sounds, stock, fillers
