"""From text to the phrases of the lexicon in it, small slips of spelling forgiven."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from functools import cache

from planner.language.lexicon import LEXICON, LONGEST, Sense

_NUMBER = r"(\d+([.,]\d+)?|an?|half an?|one|two|three|four|five|ten|a few|a couple of|some)"
_AMOUNT = re.compile(rf"\b{_NUMBER}\s*(mm|cm|(milli|centi)met(er|re)s?)\b")
_OPENING = re.compile(
    r"^(right|good|great|perfect|nice|fine|excellent|all ?right|well done)[,.!;:]+"
)
_IS = re.compile(r"(?<=arm|and|per|one|ool|ent|jaw)'s\b")  # of the nouns of an arm
_NOT_ENOUGH = re.compile(r"\b(is not|isn't|are not|aren't|not)\b(.*)\benough\b")
_TOO_CLOSE = re.compile(r"\btoo close\b")  # no word about the jaws
_BACK_AFTER = re.compile(r"\b(back|back off|out|return|retreat|withdraw) after\b")
_STOP = re.compile(
    r"^((no|please|hey|robot|calot|just) )*(stop|halt|freeze|abort)\b"
    r"|^(please )?(do not|don't|dont) move( please| now| anything)?$"
)


def normalised(text: str) -> str:
    """Lower case, plain letters, single spaces; amounts go, "not high enough" is "high".

    What begins with "stop" is "stop", whatever follows: to stop in vain does no harm.
    """
    plain = unicodedata.normalize("NFKC", text).lower().replace("’", "'").strip()
    plain = _AMOUNT.sub(" ", _OPENING.sub("", plain))
    plain = " ".join(re.sub(r"[^a-z0-9' ]+", " ", plain).split())
    plain = _NOT_ENOUGH.sub(r"\2", _IS.sub(" is", plain))
    plain = _BACK_AFTER.sub(r"\1 from", _TOO_CLOSE.sub("too near", plain))
    return "stop" if _STOP.match(plain) else plain


def senses(words: list[str]) -> Iterator[Sense | str]:
    """Of the longest phrases, from the first word on; a word that is not known as it is."""
    k = 0
    while k < len(words):
        n, sense = _longest(words[k : k + LONGEST])
        yield sense
        k += n


def _longest(words: list[str]) -> tuple[int, Sense | str]:
    for n in range(len(words), 0, -1):
        if sense := LEXICON.get(" ".join(words[:n])):
            return n, sense
    return 1, LEXICON.get(_spelt(words[0]), words[0])


@cache
def _long_words() -> frozenset[str]:
    return frozenset(word for phrase in LEXICON for word in phrase.split() if len(word) > 3)


def _spelt(word: str) -> str:
    """The known word from which one slip of the finger leads to this; or the word itself."""
    if len(word) < 4:
        return word
    near = {slip for slip in _slips(word) if slip in _long_words() and slip[0] == word[0]}
    return near.pop() if len(near) == 1 and not _inflects(word, *near) else word


def _inflects(word: str, known: str) -> bool:
    """Whether it is another form of it, as "moved" is of "move", and means something else."""
    return word.startswith(known[:-1]) and word.endswith(("s", "d", "ed", "er", "y"))


def _slips(word: str) -> Iterator[str]:
    """One letter too many or left out, two swapped, or one wrong."""
    letters = "abcdefghijklmnopqrstuvwxyz"
    for k in range(len(word) + 1):
        head, tail = word[:k], word[k:]
        yield head + tail[1:]
        yield head + tail[1:2] + tail[:1] + tail[2:]
        for letter in letters:
            yield head + letter + tail
            if len(word) > 4:  # shorter words have too many neighbours: lick, lock
                yield head + letter + tail[1:]
