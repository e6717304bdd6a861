"""Lists of phrases in TOML files: regular expressions, separated by semicolons, of whole words."""

from __future__ import annotations

import re
import tomllib
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


def _phrases(text: str) -> tuple[str, ...]:
    return tuple(" ".join(one.split()) for one in text.split(";") if one.strip())
