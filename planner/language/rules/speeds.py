"""How fast the arms may move: "slower", "half speed", "normal speed"."""

from __future__ import annotations

from planner.language.rules.phrase_lists import phrase_lists, whole_words
from planner.language.rules.warning import in_plain_letters


def speed_in(text: str) -> str:
    """Return "slower", "faster", "half", "normal", or "" if no speed is said."""
    words = in_plain_letters(text)
    lists = phrase_lists("speeds")["speeds"]
    return next((speed for speed, ps in lists.items() if whole_words(ps).search(words)), "")
