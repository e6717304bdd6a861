"""Search a text for lists of phrases and regular expressions, which TOML files hold.

A phrase is a regular expression of whole words; semicolons separate phrases. A table `patterns`
holds regular expressions, in which line breaks count for nothing and {name} stands for another one.
"""

from __future__ import annotations

import re
import tomllib
import unicodedata
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

WORDS = Path(__file__).parent / "words"
Tables = dict[str, dict[str, tuple[str, ...]]]
Rules = tuple[tuple[re.Pattern[str], str], ...]
_PART = re.compile(r"{([a-z]\w*)}")


@cache
def tables_in(name: str) -> Mapping[str, Any]:
    """Return the tables of a file of the folder `words`."""
    return tomllib.loads((WORDS / f"{name}.toml").read_text("utf-8"))


@cache
def phrase_lists(name: str) -> Tables:
    """Return the phrases of a file, by table and key; line breaks are spaces."""
    return {
        table: {key: _phrases(text) for key, text in keys.items()}
        for table, keys in tables_in(name).items()
    }


@cache
def patterns(name: str) -> Mapping[str, re.Pattern[str]]:
    """Return the regular expressions of a file, by name."""
    parts = tables_in(name)["patterns"]
    return {key: re.compile(filled(text, parts)) for key, text in parts.items()}


@cache
def rules_in(name: str, table: str, flags: int = 0) -> Rules:
    """Return the rules of a file: regular expressions, and what takes their place."""
    tables = tables_in(name)
    rows = tables["rules"][table]
    return tuple((re.compile(filled(p, tables["patterns"]), flags), to) for p, to in rows)


def rewritten(text: str, rules: Iterable[tuple[re.Pattern[str], str]]) -> str:
    """Apply rules to a text, in order."""
    for pattern, instead in rules:
        text = pattern.sub(instead, text)
    return text


def filled(text: str, parts: Mapping[str, str]) -> str:
    """Return a regular expression on one line, with its parts, and theirs, filled in."""
    while _PART.search(text):
        text = _PART.sub(lambda match: parts[match[1]], text)
    return text.replace("\n", "")


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
