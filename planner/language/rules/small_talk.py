"""Recognise what orders nothing: small talk, and the asides beside an order.

Small talk is of meals and journeys, praise, and reports of progress; small_talk.toml lists it.
Asides are politeness, and that all is well; asides.toml lists them.
"""

from __future__ import annotations

import re
from functools import cache

from planner.language.rules.phrase_search import in_plain_letters, phrase_lists, whole_words


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


_POLITELY = "would you please "


def without_asides(text: str) -> str:
    """Return a text with plain politeness, and without clauses that only say that all is well."""
    begins, ends, polite = _patterns()
    return polite.sub(_POLITELY, ends.sub("", begins.sub("", text)))


@cache
def _patterns() -> tuple[re.Pattern[str], re.Pattern[str], re.Pattern[str]]:
    """Return what finds clauses of content at the beginning, at the end, and politeness."""
    lists = phrase_lists("asides")["asides"]
    well, polite = (rf"(?:{'|'.join(lists[name])})" for name in ("well", "polite"))
    patterns = (
        rf"^(?:{well}[,.;:!]+ *(?:so |and )?)+(?=\w)",
        rf"(?<=\w)(?:[,;:.]+ *(?:and |as |since |because |now )?{well})+ *[.!]*$",
        rf"(?<!\w){polite}(?: please,?)?(?!\w) *",
    )
    begins, ends, politely = (re.compile(one, re.IGNORECASE) for one in patterns)
    return begins, ends, politely
