"""How far a correction goes: a length that is said, or how much "a bit" and "much" are."""

from __future__ import annotations

import re
from dataclasses import dataclass

from planner.language.rules.phrase_lists import phrase_lists, whole_words
from planner.language.rules.plain_letters import not_drawn_out

SMALL_M, LARGE_M = 0.0015, 0.008  # "a bit", "much"; assumed
LONGEST_M = 0.05  # nobody means more in Calot's triangle

_NUMBERS = {
    "a": 1.0, "an": 1.0, "another": 1.0, "one": 1.0, "two": 2.0, "three": 3.0, "four": 4.0,
    "five": 5.0, "six": 6.0, "seven": 7.0, "eight": 8.0, "nine": 9.0, "ten": 10.0, "eleven": 11.0,
    "twelve": 12.0, "fifteen": 15.0, "twenty": 20.0, "thirty": 30.0, "couple of": 2.0,
    "couple": 2.0, "few": 3.0, "half": 0.5, "half a": 0.5, "half an": 0.5, "quarter": 0.25,
    "quarter of a": 0.25, "quarter of an": 0.25, "eighth of an": 0.125,
    "sixteenth of an": 0.0625, "third of a": 1 / 3, "tenth of a": 0.1, "tenth of an": 0.1,
    "three quarters of a": 0.75, "three quarters of an": 0.75, "to": 2.0, "too": 2.0,
}  # fmt: skip
_TENTHS = ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_NUMBERS |= {f"{one} tenths of a": _NUMBERS[one] / 10.0 for one in _TENTHS}
_UNITS_M = {
    r"(?:mms?|mils?|millis?|mil+im(?:et(?:er|re)s?))": 1e-3,
    r"(?:cms?|cent(?:i|e)m(?:et(?:er|re)s?)|centis?)": 1e-2,
    r"inch(?:es)?": 0.0254,
    r"in(?:$|[.,!?])": 0.0254,
    r"(?:microns?|micromet(?:er|re)s?)": 1e-6,
    r"fingers?(?: |')?s?(?: |-)?(?:breadths?|widths?)?": 0.018,  # a finger's breadth
    r"hair(?: |'s )?breadths?": 5e-4,
}
_WORDS = "|".join(sorted(_NUMBERS, key=len, reverse=True))
_DIGITS = "(?:one|two|three|four|five|six|seven|eight|nine)"
_NUMBER = (
    r"\d+(?:[.,]\d+)?(?: ?/ ?\d+)?"
    rf"|(?:(?:{_DIGITS}|zero|nought|oh) )?point (?:\d+|{_DIGITS})|\.\d+|{_WORDS}"
)
_HALVES = {"half": 0.5, "quarter": 0.25}
_AND_HALF = r"(?: and (?:a )?(half|quarter))?"
_ABOUT = (
    r"(?:\bby )?(?:\b(?:about|like|roughly|around|circa|approximately|perhaps|only|exactly|just"
    r"|some|maybe|up to|at most|at least) (?:an? )?|\ban? )?"
)
_MORE = r"(?:(?:more|good|full|whole|mere|bare|further|extra|additional) )?"
_LENGTH = {
    re.compile(
        rf"{_ABOUT}(?<![\w.])({_NUMBER}){_AND_HALF} ?{_MORE}(?:of an? )?{_MORE}{unit}(?!\w)"
        rf"{_AND_HALF}"
    ): unit_m
    for unit, unit_m in _UNITS_M.items()
}


@dataclass(frozen=True, kw_only=True)
class Sized:
    """A text without its size, and the size.

    Attributes:
        size_m: None if none is said.
    """

    text: str
    size_m: float | None = None


def without_size(text: str) -> Sized:
    """Return a text with its size taken out; of two lengths the first counts."""
    plain = not_drawn_out(" ".join(text.lower().replace("-", " ").split()))
    for pattern, unit_m in _LENGTH.items():
        if found := pattern.search(plain):
            count = _number(found[1]) + _HALVES.get(found[2] or found[3] or "", 0.0)
            return Sized(text=_without(found, plain), size_m=min(count * unit_m, LONGEST_M))
    for vague, size_m in (("much", LARGE_M), ("a bit", SMALL_M)):
        if found := whole_words(phrase_lists("sizes")["sizes"][vague]).search(plain):
            return Sized(text=_without(found, plain), size_m=size_m)
    return Sized(text=text)


def _without(found: re.Match[str], text: str) -> str:
    return " ".join(f"{text[: found.start()]} {text[found.end() :]}".split())


def _number(said: str) -> float:
    if said in _NUMBERS:
        return _NUMBERS[said]
    if "point" in said:
        ones, digits = (part.strip() for part in said.split("point"))
        return _NUMBERS.get(ones, 0.0) + float(f"0.{round(_NUMBERS.get(digits, 0)) or digits}")
    whole, _, under = said.replace(" ", "").replace(",", ".").partition("/")
    return float(whole) / float(under or 1.0) if float(under or 1.0) else 0.0
