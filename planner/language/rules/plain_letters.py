"""A text as rules search it: in plain letters, with nothing drawn out."""

from __future__ import annotations

import re
import unicodedata

_DRAWN_OUT = re.compile(r"([a-z])\1{2,}")


def in_plain_letters(text: str) -> str:
    """Return a text in lower case, without accents or punctuation, with single spaces."""
    plain = unicodedata.normalize("NFKD", text.lower().replace("’", "'"))
    plain = "".join(one for one in plain if not unicodedata.combining(one)).replace("ß", "ss")
    return " ".join(re.findall(r"[\w']+", not_drawn_out(plain)))


def not_drawn_out(text: str) -> str:
    """Return a text in which a letter that is drawn out is there once: "waaait" becomes "wait"."""
    return _DRAWN_OUT.sub(r"\1", text)
