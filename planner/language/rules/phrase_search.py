"""Search a text in plain letters for lists of phrases, which TOML files hold.

A phrase is a regular expression of whole words; semicolons separate phrases.
"""

from __future__ import annotations

import re
import tomllib
import unicodedata
from functools import cache
from pathlib import Path

WORDS = Path(__file__).parent / "words"
Tables = dict[str, dict[str, tuple[str, ...]]]


@cache
def phrase_lists(name: str) -> Tables:
    """Return the phrases of a file of this folder, by table and key; line breaks are spaces."""
    tables = tomllib.loads((WORDS / f"{name}.toml").read_text("utf-8"))
    return {
        table: {key: _phrases(text) for key, text in keys.items()} for table, keys in tables.items()
    }


@cache
def whole_words(phrases: tuple[str, ...]) -> re.Pattern[str]:
    """Return what finds any of the phrases, not as a part of a word."""
    return re.compile(rf"(?<![\w'])(?:{'|'.join(phrases)})(?![\w'])")


def longest_first(phrases: tuple[str, ...]) -> str:
    """Return a pattern of any of the phrases, the longest first, which never tries a second one.

    So a text of many of them is matched in a time that grows with its length alone.
    """
    return rf"(?>{'|'.join(sorted(phrases, key=len, reverse=True))})"


def _phrases(text: str) -> tuple[str, ...]:
    return tuple(" ".join(one.split()) for one in text.split(";") if one.strip())


_DRAWN_OUT = re.compile(r"([a-z])\1{2,}")
_WORD = re.compile(r"\d+[.,/]\d+|(?<!\S)\.\d+|[\w']+")  # 2.5, 1/4 and .5 are words


def in_plain_letters(text: str) -> str:
    """Return a text in lower case, without accents or punctuation, with single spaces.

    A number stays whole: "2.5".
    """
    plain = unicodedata.normalize("NFKD", text.lower().replace("’", "'"))
    plain = "".join(one for one in plain if not unicodedata.combining(one)).replace("ß", "ss")
    return " ".join(_WORD.findall(not_drawn_out(plain)))


def not_drawn_out(text: str) -> str:
    """Return a text in which a letter that is drawn out is there once: "waaait" becomes "wait"."""
    return _DRAWN_OUT.sub(r"\1", text)
