"""Read how far or how fast an arm goes: a length, a share of another motion, or a speed.

Examples are "2 mm", "a bit", "half of that", "likewise" and "half speed".
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from planner.language.rules.phrase_search import (
    filled,
    in_plain_letters,
    not_drawn_out,
    phrase_lists,
    tables_in,
    whole_words,
)

SMALL_M, LARGE_M = 0.0015, 0.008  # "a bit", "much"; assumed
SHORTEST_M = 2e-4  # less is gone as soon as it is said (`planner.person.orders.REACHED_M`); assumed
LONGEST_M = 0.05  # nobody means more in Calot's triangle, which is smaller; assumed

_TABLES = tables_in("lengths")
_NUMBERS: dict[str, float] = dict(_TABLES["numbers"])
_ONES = ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_TENS = ("twenty", "thirty", "forty", "fifty")
_PARTS_OF = {"third": 3, "fourth": 4, "fifth": 5, "eighth": 8, "tenth": 10, "sixteenth": 16}
_NUMBERS |= {f"{part} of {a}": 1 / n for part, n in _PARTS_OF.items() for a in ("a", "an")}
_NUMBERS |= {f"two thirds of {a}": 2 / 3 for a in ("a", "an")}
_NUMBERS |= {f"{one} tenths of a": _NUMBERS[one] / 10.0 for one in _ONES}
_NUMBERS |= {f"{ten} {one}": _NUMBERS[ten] + _NUMBERS[one] for ten in _TENS for one in _ONES}
_COUNTED = (one for one in _NUMBERS if _NUMBERS[one] > 1.0 and one not in ("to", "too"))
_PARTS = _TABLES["patterns"] | {
    "words": "|".join(sorted(_NUMBERS, key=len, reverse=True)),
    "counted": "|".join(_COUNTED),
    "ones": "|".join(_ONES),
}
_RE = {name: re.compile(filled(text, _PARTS)) for name, text in _TABLES["patterns"].items()}
_LENGTH = {
    re.compile(filled(_TABLES["length"]["in_units"], _PARTS | {"unit": unit})): unit_m
    for unit, unit_m in _TABLES["units_m"].items()
}
_TIMES = {re.compile(filled(said, _PARTS)): times for said, times in _TABLES["echoes"]["times"]}
_HALVES = {"half": 0.5, "quarter": 0.25}
_PARTS_OF_ONE = (("½", ".5"), ("¼", ".25"), ("¾", ".75"))  # "1½ mm"


@dataclass(frozen=True, kw_only=True)
class Sized:
    """A text without its size, and the size.

    Attributes:
        size_m: None if none is said.
        measured: it has a unit; "a bit" has none.
    """

    text: str
    size_m: float | None = None
    measured: bool = False


def without_size(text: str) -> Sized:
    """Return a text with its size taken out; of two lengths the first counts."""
    plain = _plain(text)
    for pattern, unit_m in _LENGTH.items():
        if found := pattern.search(plain):
            count = _number(found[1]) + _HALVES.get(found[2] or found[3] or "", 0.0)
            return Sized(text=_without(found, plain), size_m=count * unit_m, measured=True)
    for vague, size_m in (("much", LARGE_M), ("a bit", SMALL_M)):
        if found := whole_words(phrase_lists("sizes")["sizes"][vague]).search(plain):
            return Sized(text=_without(found, plain), size_m=size_m)
    return Sized(text=text)


def unclear_length(text: str) -> str:
    """Return why a length in a text cannot be told; "" if each can: "-3 mm", "2 to 3 mm"."""
    lengths = (found for pattern in _LENGTH for found in pattern.finditer(_plain(text)))
    if any(_RE["other_number"].search(found.string[: found.start()].rstrip()) for found in lengths):
        return "there is more than one number before the unit"
    return (
        "a length has no minus, say the other direction"
        if _RE["minus"].search(text.lower())
        else ""
    )


def unread_length(english: str) -> str:
    """Return why a length has no number that can be read; "" if each has: "nan mm", "1e3 mm"."""
    unread = _RE["unread"].search(_without_lengths(english))
    return f"{unread[0].strip()!r} has no number that can be read" if unread else ""


def without_unit(text: str) -> str:
    """Return a number, at the end or before a direction, that no unit follows; or ""."""
    found = _RE["no_unit"].search(_without_lengths(text))
    return found[1] if found else ""


def _without_lengths(text: str) -> str:
    plain = _plain(text)
    for pattern in _LENGTH:
        plain = pattern.sub(" ", plain)
    return plain


def out_of_range(size_m: float | None) -> str:
    """Return why an arm does not go so far at a time; "" if it does."""
    if size_m is None or SHORTEST_M <= size_m <= LONGEST_M:
        return ""
    allowed = f"{1e3 * SHORTEST_M:g} to {1e3 * LONGEST_M:g} mm"
    return f"{1e3 * size_m:g} mm is not within {allowed}"


def _plain(text: str) -> str:
    for sign, decimals in _PARTS_OF_ONE:
        text = text.replace(sign, decimals)
    plain = not_drawn_out(" ".join(text.lower().replace("-", " ").split()))
    return _RE["thousands"].sub(r"\1\2", plain)


def _without(found: re.Match[str], text: str) -> str:
    return " ".join(f"{text[: found.start()]} {text[found.end() :]}".split())


def _number(said: str) -> float:
    if said in _NUMBERS:
        return _NUMBERS[said]
    if "point" in said:
        ones, digits = (part.strip() for part in said.split("point"))
        whole = float(ones) if ones.isdecimal() else _NUMBERS.get(ones, 0.0)
        return whole + float(f"0.{round(_NUMBERS.get(digits, 0)) or digits}")
    whole, _, under = said.replace(" ", "").replace(",", ".").partition("/")
    return float(whole) / float(under or 1.0) if float(under or 1.0) else 0.0


# Speeds


def speed_in(text: str) -> str:
    """Return "slower", "faster", "half", "normal", or "" if no speed is said."""
    speed, _ = _found(in_plain_letters(text))
    return speed


def without_speed(text: str) -> str:
    """Return a sentence in plain letters without the words about a speed: "clip the duct"."""
    words = in_plain_letters(text)
    _, found = _found(words)
    if found is None:
        return text
    before = _RE["link"].sub("", words[: found.start()])
    return f"{before} {words[found.end() :].lstrip(' ,')}".strip()


def _found(words: str) -> tuple[str, re.Match[str] | None]:
    lists = phrase_lists("speeds")["speeds"]
    found = ((speed, whole_words(ps).search(words)) for speed, ps in lists.items())
    return next(((speed, at) for speed, at in found if at), ("", None))


# Echoes: a part of a sentence says its motion by the part before


@dataclass(frozen=True, kw_only=True)
class Echo:
    """What a part says besides, and how many times as far as the motion before it goes."""

    text: str
    times: float


def echo_in(part: str) -> Echo | None:
    """Return what a part says of the motion before it; None if it says nothing of it."""
    text, times, found = part, 1.0, False
    for pattern, factor in _TIMES.items():
        text, n = pattern.subn(" ", text)
        found, times = found or bool(n), times * (factor if n else 1.0)
    return (
        Echo(text=" ".join(re.sub(r"\bbut\b|,", " ", text).split()), times=times) if found else None
    )
