"""Negation, alarm and doubt hold both arms, whatever else the sentence says.

A rule, not a classifier: a warning that is missed may injure, one that is heard in vain costs a
second. The words are in warnings.toml, in six languages.
"""

from __future__ import annotations

import re
from functools import cache

from planner.language.rules.phrase_search import in_plain_letters, phrase_lists, whole_words


def warns(text: str) -> bool:
    """Return whether a text denies, alarms or doubts, in any of the languages."""
    words = in_plain_letters(text)
    if any(sign in words for sign in phrase_lists("warnings")["alarms"]["chinese"]):
        return True
    return bool(_alarms().search(_harmless().sub(" ", words)))


def warns_mildly(text: str) -> bool:
    """Return whether words that stand in calm talk, too, are all that warns: "no sugar for me"."""
    mild = whole_words(phrase_lists("warnings")["mild"]["words"])
    return not warns(mild.sub(" ", in_plain_letters(text)))


def warns_anywhere(text: str) -> bool:
    """Return whether a single word of a text of any length warns; phrases are not looked for."""
    words = in_plain_letters(text)
    signs = phrase_lists("warnings")["alarms"]["chinese"]
    return not _single_words().isdisjoint(words.split()) or any(sign in words for sign in signs)


@cache
def _single_words() -> frozenset[str]:
    lists = phrase_lists("warnings")["alarms"]
    return frozenset(one for ones in lists.values() for one in ones if one.isalpha())


def without_warning(text: str) -> str:
    """Return what is left of a sentence without its warning words."""
    return " ".join(_alarms().sub(" ", _harmless().sub(" ", in_plain_letters(text))).split())


@cache
def _alarms() -> re.Pattern[str]:
    lists = phrase_lists("warnings")["alarms"]
    return whole_words(tuple(p for name, ps in lists.items() if name != "chinese" for p in ps))


def _harmless() -> re.Pattern[str]:
    return whole_words(phrase_lists("warnings")["harmless"]["phrases"])
