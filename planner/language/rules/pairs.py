"""Split an order to both arms into one order for each arm.

The arms may go apart, together, or each its own way. A sentence may also name a direction by the
other arm: the grasper's side is to the applier's left.
"""

from __future__ import annotations

import re

from planner.language.rules.phrase_search import patterns, rewritten, rules_in
from planner.language.rules.sizes import without_size

_RE = patterns("pairs")
_LENGTH_WORDS = range(1, 6)  # of "by two and a half millimetres"


def arm_by_arm(text: str) -> str:
    """Return a lower-case sentence in which each arm has its own part, in the order of doing."""
    text = _with_arms_named(rewritten(text, rules_in("pairs", "in_order")))
    return _each_by_its_own(text) or _all_by_the_same(text)


def _with_arms_named(text: str) -> str:
    """Return a text in which "the left ... the right", "grasper and scissors" are named as arms."""
    if len(set(_RE["the_side"].findall(text))) == len(("left", "right")):
        text = _RE["the_side"].sub(r"\1 arm", text)
    text = _RE["both_named"].sub("both arms", text)
    if _RE["everything"].search(text):
        text = "both arms " + _RE["everything"].sub("", _RE["both_arms"].sub("", text)).strip()
    return text


def _each_by_its_own(text: str) -> str:
    """Write out "both arms down, left by 1 mm, right by 3 mm"; return "" for any other text."""
    found = _RE["own_sizes"].match(text)
    way, one, size, other, other_size = found.groups() if found else ("",) * 5
    if one == other or not (without_size(size).size_m and without_size(other_size).size_m):
        return ""
    parts = ((one, size), (other, other_size))
    arms = _RE["arms"]
    return ", then ".join(f"{arms.sub(f'{side} arm', way, 1)} by {m}" for side, m in parts)


def _all_by_the_same(text: str) -> str:
    """Write out "arms apart", and give each part the length that is said for "each"."""
    text, size = _without_each(text)
    for pattern, ways in ((_RE["apart"], ("left", "right")), (_RE["together"], ("right", "left"))):
        if pattern.search(text):
            size = size or _size_in(text)
            return f"left arm to the {ways[0]}{size}, then right arm to the {ways[1]}{size}"
    return re.sub(r",? and |, ", lambda joint: f"{size}{joint[0]}", text) + size


def _without_each(text: str) -> tuple[str, str]:
    """Return a text without "by 2 mm each", and that length; "" if it does not end so."""
    found = _RE["each"].search(text)
    words = text[: found.start()].split() if found else []
    for n in _LENGTH_WORDS:
        length = without_size(" ".join(words[-n:])) if len(words) > n else None
        if length and length.size_m and not length.text.strip(", "):
            return " ".join(words[:-n]).rstrip(","), f" by {' '.join(words[-n:])}"
    return text, ""


def _size_in(text: str) -> str:
    size_m = without_size(text).size_m
    return "" if size_m is None else f" by {1e3 * size_m:g} mm"


def without_other_arm(text: str) -> str:
    """Return a text with a direction in place of the other arm as its goal."""
    for pattern, instead in rules_in("pairs", "without_other_arm"):
        replaced, n = pattern.subn(instead, text.lower(), count=1)
        if n:
            return replaced
    return text
