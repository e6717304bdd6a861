"""A text as rules search it: in plain letters, with nothing drawn out."""

from __future__ import annotations

import re
import unicodedata

_DRAWN_OUT = re.compile(r"([a-z])\1{2,}")
_WORDS = re.compile(r"\d+[.,/]\d+|(?<!\S)\.\d+|[\w']+")  # 2.5, 1/4 and .5 are words


def in_plain_letters(text: str) -> str:
    """Return a text in lower case, without accents or punctuation, with single spaces.

    A number stays whole: "2.5".
    """
    plain = unicodedata.normalize("NFKD", text.lower().replace("’", "'"))
    plain = "".join(one for one in plain if not unicodedata.combining(one)).replace("ß", "ss")
    return " ".join(_WORDS.findall(not_drawn_out(plain)))


def not_drawn_out(text: str) -> str:
    """Return a text in which a letter that is drawn out is there once: "waaait" becomes "wait"."""
    return _DRAWN_OUT.sub(r"\1", text)
