"""Mend letters and words that are misspelt, and give the third tube one name.

Letters are taken for what they look like, without hidden ones and spaces between them. Words are
misspelt as by a keyboard or by speech recognition. They are those of the theatre, and of whom a
sentence addresses.
"""

from __future__ import annotations

import re
import unicodedata
from functools import cache

from planner.language.rules.phrase_search import (
    patterns,
    phrase_lists,
    rewritten,
    rules_in,
    whole_words,
)
from planner.language.rules.warning import warns


def as_meant(text: str) -> str:
    """Return a text with the words that are misspelt in known ways as they are meant."""
    text = rewritten(text, _spellings())
    return rewritten(text, rules_in("as_meant", "as_meant", re.IGNORECASE))


@cache
def _spellings() -> tuple[tuple[re.Pattern[str], str], ...]:
    words = phrase_lists("spellings")["words"]
    return tuple((re.compile(whole_words(ps).pattern, re.IGNORECASE), w) for w, ps in words.items())


# Letters

_LOOK_ALIKES = str.maketrans(
    "аеорсухіјѕԁһкмтвнзгԛԝАЕОРСУХІЈЅВНКМТЗαεορικντυχηΑΒΕΖΗΙΚΜΝΟΡΤΥΧϲ",
    "aeopcyxijsdhkmtbh3rqwAEOPCYXIJSBHKMT3aeopikvtuxnABEZHIKMNOPTYXc",
)
_HIDDEN = re.compile(
    r"[\x00-\x08\x0e-\x1f\x7f-\x9f\u00ad\u200b-\u200f\u202a-\u202e\u2060-\u206f\ufeff]"
)
_NO_FRACTION = re.compile("[^½¼¾]+")
_OTHER_LETTERS = re.compile(r"[\u0370-\u1dff\u2c00-\uabff\uac00-\ud7ff]")
_SPACED = re.compile(r"(?<![\w'])(?:[^\W\d_][ .\-_*]{1,2}){2,}[^\W\d_](?![\w'])")


def in_latin(text: str) -> str:
    """Return a text as it is seen: without hidden characters, in Latin letters, words unspaced.

    Letters of another script count as what they look like only where all of the text does.
    """
    if not text.isascii():
        text = _NO_FRACTION.sub(lambda part: unicodedata.normalize("NFKC", part[0]), text)
        plain = text.translate(_LOOK_ALIKES)
        text = text if _OTHER_LETTERS.search(plain) else plain
    return _SPACED.sub(lambda spaced: _joined(spaced[0]), _HIDDEN.sub("", text))


def _joined(spaced: str) -> str:
    """Return a warning that is spelt, "s-t-o-p", as a word; other letters as they are."""
    word = re.sub(r"[ .\-_*]", "", spaced)
    return word if warns(word) else spaced


# The third tube: "second artery", "accessory vessel"

THIRD_TUBE = "thirdtube"  # one word, so that no rule reads a clip's number in it


def with_third_tube(text: str) -> str:
    """Return a text in which every name of the third tube is `THIRD_TUBE`.

    The number of an artery and that of a clip are the same words. So the name is taken out of a
    text before any clip is counted: "second clip on the second artery".
    """
    if patterns("third_tube")["other_count"].search(text):
        return text
    return rewritten(text, rules_in("third_tube", "names", re.IGNORECASE))


def with_artery(text: str) -> str:
    """Return a text with the artery in place of the third tube, for what knows two tubes only.

    What a sentence does with a tube does not depend on the tube.
    """
    return text.replace(THIRD_TUBE, "artery")
