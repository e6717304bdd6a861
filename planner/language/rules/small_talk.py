"""Talk of meals and journeys, praise, and reports of progress; small_talk.toml lists it."""

from __future__ import annotations

from planner.language.rules.phrase_lists import phrase_lists, whole_words
from planner.language.rules.plain_letters import in_plain_letters


def is_small_talk(text: str) -> bool:
    """Return whether a text names a topic of small talk, asks others, praises or tells progress."""
    words = in_plain_letters(text)
    elsewhere = _finds("topics", words) or _finds("asked_of_others", words)
    if elsewhere and not _finds("operation", words):
        return True
    if _finds("remarks", words) and not _finds("unless", words):
        return True
    progress = whole_words(phrase_lists("small_talk")["small_talk"]["progress"])
    return progress.fullmatch(words) is not None


def _finds(kind: str, words: str) -> bool:
    return whole_words(phrase_lists("small_talk")["small_talk"][kind]).search(words) is not None
