"""A slip of the tongue that is mended at once: "clip the left tube, I mean the right tube"."""

from __future__ import annotations

from planner.language.rules.phrase_search import patterns

_RE = patterns("corrected")
_ALIKE = tuple(_RE[f"another_{one}"] for one in ("tube", "arm", "number", "way", "length"))
_ORDERS = tuple(_RE[f"orders_of_{one}"] for one in ("deeds", "jaws", "motions"))


def as_corrected(text: str) -> str:
    """Return a text in which the words that a person takes back are replaced by the right ones.

    Where it is not clear by what, the text says that it is sorry, which is no order.
    """
    halves = [half.strip(" ,.;:!") for half in _RE["mends"].split(text.lower())]
    if len(halves) < len(("wrong", "right")) or not all(halves):
        return text
    if not any(alike.search(halves[-1]) for alike in _ALIKE):  # "I mean, a lot"
        return text
    *_, wrong, right = halves
    mended = _mended(wrong, right) if len(halves) == len((wrong, right)) else ""
    return mended or ", sorry, ".join(halves)


def _mended(wrong: str, right: str) -> str:
    """Return the right words, with what they leave unsaid; empty if that is not clear."""
    meant, taken_back = (_orders(half) for half in (right, wrong))
    if meant and meant == (taken_back or meant):
        return "" if _RE["joined"].search(wrong) else right
    for alike in _ALIKE:
        if alike.fullmatch(right) and len(alike.findall(wrong)) == 1:
            return alike.sub(right, wrong)
    return ""


def _orders(text: str) -> list[bool]:
    """Return which kinds of order a text has: deeds, jaws, motions; empty if it has none."""
    kinds = [pattern.fullmatch(text) is not None for pattern in _ORDERS]
    return kinds if any(kinds) else []
