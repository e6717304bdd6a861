"""From text to phrases of the lexicon, with small spelling mistakes corrected."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from functools import cache

from planner.language.lexicon import LEXICON, LONGEST, Meaning, without_articles
from planner.language.rules.phrase_search import patterns, rewritten, rules_in
from planner.language.rules.spelling import with_third_tube

_RE = patterns("rewrites")
_AS_TYPED = rules_in("rewrites", "as_typed")  # before punctuation is removed
_AS_SAID = tuple(
    rule
    for table in ("short", "polite", "last", "things", "too", "towards")
    for rule in rules_in("rewrites", table)
)


def normalised(text: str) -> str:
    """Return the text in lower case, plain letters, single spaces, corrected and rewritten.

    A text that begins with "stop" becomes "stop": an unnecessary stop does no harm.
    """
    plain = with_third_tube(unicodedata.normalize("NFKC", text).lower().strip())
    plain = re.sub(r"[^a-z0-9' ]+", " ", rewritten(plain, _AS_TYPED))
    plain = " ".join(map(_spelt, without_articles(plain).split()))
    plain = without_articles(rewritten(plain, _AS_SAID))
    return "stop" if _RE["stop"].search(plain) else plain


def senses(words: list[str]) -> Iterator[Meaning | str]:
    """Yield the senses of the longest phrases, from the first word on; unknown words unchanged."""
    k = 0
    while k < len(words):
        n, sense = _longest(words[k : k + LONGEST])
        yield sense
        k += n


def _longest(words: list[str]) -> tuple[int, Meaning | str]:
    for n in range(len(words), 0, -1):
        if sense := LEXICON.get(" ".join(words[:n])):
            return n, sense
    return 1, Meaning("filler", "any") if _RE["how"].fullmatch(words[0]) else words[0]


@cache
def _known_words() -> frozenset[str]:
    return frozenset(word for phrase in LEXICON for word in phrase.split())


@cache
def _mended_words() -> frozenset[str]:
    """Return the words whose spelling is corrected: those of commands, and their nouns."""
    idle = {p for p, sense in LEXICON.items() if sense.slot in ("refusal", "filler", "is")}
    words = (word for phrase in LEXICON.keys() - idle for word in phrase.split())
    kept = (word for word in words if word not in idle or f"left {word}" in LEXICON)
    return frozenset(word for word in kept if len(word) > 2)


def _spelt(word: str) -> str:
    """Return the one known word that is a single typing mistake away, else the word itself."""
    if len(word) < 3 or word in _known_words():
        return word
    for slips in _slips(word):
        near = {slip for slip in slips if slip in _mended_words() and slip[0] == word[0]}
        if near:
            return near.pop() if len(near) == 1 and not _inflects(word, *near) else word
    return word


def _inflects(word: str, known: str) -> bool:
    """Return whether a word is another form of a known one ("moves") with another meaning."""
    ending = word.endswith(("s", "d", "ed", "er", "y")) and word[-1] != known[-1]
    return word.startswith(known[:-1]) and ending


def _slips(word: str) -> Iterator[set[str]]:
    """Yield corrections of one mistake, likeliest first: swapped, missing, extra, wrong letter."""
    letters = "abcdefghijklmnopqrstuvwxyz"
    splits = [(word[:k], word[k:]) for k in range(len(word) + 1)]
    yield {head + tail[1] + tail[0] + tail[2:] for head, tail in splits if len(tail) > 1}
    if len(word) > 3:  # shorter words have too many neighbours
        yield {head + letter + tail for head, tail in splits for letter in letters}
        yield {head + tail[1:] for head, tail in splits}
    if len(word) > 4:  # lick, lock
        yield {head + letter + tail[1:] for head, tail in splits for letter in letters}
