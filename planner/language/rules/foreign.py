"""From the words of other languages to English ones, word by word; foreign.toml lists them.

A surgeon in a fright falls back on the mother tongue. What is translated are the words of commands
alone; the English grammar reads the result, and asks back where word order was lost.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

from planner.language.lexicon import LEXICON
from planner.language.rules.phrase_search import in_plain_letters, tables_in

NOT_ENGLISH = "it is not in English"  # the lexicon's own list of foreign words
SHARED = "shared"  # words that English has, too
_CHINESE, _JAPANESE = re.compile(r"[\u4e00-\u9fff]"), re.compile(r"[\u3040-\u30ff]")
_ELIDED = re.compile(r"\b(l|d|n|s|m|qu|un|sull|dell|all|dall|nell)'(?=\w)")


def in_english(text: str) -> str:
    """Return an English text unchanged, and of another one the words that commands need."""
    if _JAPANESE.search(text):
        return text
    if _CHINESE.search(text):
        return _translated(text, "chinese", apart="")
    plain = _elided_apart(in_plain_letters(text))
    words = set(plain.split())
    own = {name: len(words & _own_words(name)) for name in _tables() if name != "chinese"}
    language = max(own, key=lambda name: own[name])
    return _translated(plain, language, apart=r"(?<![\w'])") if own[language] else text


def _elided_apart(text: str) -> str:
    """Return a text with elided words on their own: "l' artere"."""
    return _ELIDED.sub(r"\1' ", text)


def _translated(text: str, language: str, *, apart: str) -> str:
    found = _tables()[language]
    longest_first = sorted(found, key=len, reverse=True)
    after = r"(?!\w)" if apart else ""
    one = re.compile(rf"{apart}({'|'.join(map(re.escape, longest_first))}){after}")
    return " ".join(one.sub(lambda match: f" {found[match[0]]} ", text).split())


@cache
def _tables() -> Mapping[str, Mapping[str, str]]:
    """Return, by language, the English of every phrase."""
    return {
        language: _numbers(language)
        | {
            _elided_apart(one.strip()): english
            for english, ones in table.items()
            for one in ones.split(",")
        }
        for language, table in tables_in("foreign").items()
        if language != SHARED
    }


def _numbers(language: str) -> dict[str, str]:
    """Return the digits of every number up to fifty, by its word."""
    named = tables_in("numbers")["numbers"][language]
    words = (" ".join(word.split()) for word in named.split(","))
    return {word: str(k + 1) for k, word in enumerate(words)}


@cache
def _own_words(language: str) -> frozenset[str]:
    """Return the words of a language that English and its lexicon do not have."""
    said = (phrase for phrase, sense in LEXICON.items() if sense.value != NOT_ENGLISH)
    english = {word for phrase in said for word in phrase.split()}
    english |= set(tables_in("foreign")[SHARED]["words"].split())
    ours = {w for phrase in _tables()[language] for w in phrase.split() if len(w) > 2}
    return frozenset(ours - english)
