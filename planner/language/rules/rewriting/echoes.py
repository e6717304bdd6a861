"""A part of a sentence that says its motion by the part before: "likewise", "half of that"."""

from __future__ import annotations

import re
from dataclasses import dataclass

_FAR = r"(?:much|far)"
_TIMES = {
    rf"half (?:of )?(?:that|as {_FAR})(?: again)?|(?<=by )half(?! an?\b)(?! \w*met)"
    r"|half (?:of )?it|half the (?:distance|amount|way)": 0.5,
    rf"a (?:quarter|fourth) (?:of (?:that|it)|as {_FAR})|(?:by )?a quarter as {_FAR}": 0.25,
    rf"a third (?:of that|as {_FAR})": 1 / 3,
    rf"(?:twice|two times) (?:that|as {_FAR}|the (?:distance|amount))|double(?: that)?": 2.0,
    rf"(?:three times|thrice) (?:that|as {_FAR})|triple(?: that)?": 3.0,
    r"likewise|ditto|(?:the )?same(?! (?:arm|hand|gripper|one|side)\b)"
    r"(?: again)?(?: (?:way|amount|distance|thing|direction|for))?"
    r"|(?:by )?the same(?: (?:again|amount|distance))?|as (?:much|far)|so too": 1.0,
}
_PATTERNS = {re.compile(rf"\b(?:by )?(?:{said})\b"): times for said, times in _TIMES.items()}


@dataclass(frozen=True, kw_only=True)
class Echo:
    """What a part says besides, and how many times as far as the motion before it goes."""

    text: str
    times: float


def echo_in(part: str) -> Echo | None:
    """Return what a part says of the motion before it; None if it says nothing of it."""
    text, times, found = part, 1.0, False
    for pattern, factor in _PATTERNS.items():
        text, n = pattern.subn(" ", text)
        found, times = found or bool(n), times * (factor if n else 1.0)
    return (
        Echo(text=" ".join(re.sub(r"\bbut\b|,", " ", text).split()), times=times) if found else None
    )
