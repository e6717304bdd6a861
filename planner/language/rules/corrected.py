"""A slip of the tongue that is mended at once: "clip the left tube, I mean the right tube"."""

from __future__ import annotations

import re

_I_MEAN = r"(?:i meant?(?: to say)?|make that|should say)"
_MENDS = re.compile(
    r"[,;.:]* *\b(?:(?:oh|um|uh|er|ah),? )?"
    rf"(?:(?<=[,;.:] )(?:or rather|correction|(?:sorry|pardon(?: me)?|apologies|i misspoke)"
    rf"(?! (?:to|for|about|but|if|we|you|it)\b)),? *(?:(?:that's|that is|{_I_MEAN}),? *)?"
    rf"|{_I_MEAN}),? *"
)
_TUBE = r"(?:(?:left|right) (?:tube|vessel|structure)|(?:cystic )?(?:duct|artery))"
_ARM = r"(?:(?:left|right) (?:arm|hand|gripper|grasper|jaws?|instrument|tool))"
_NUMBER = r"(?:(?:clip )?(?:number )?(?:one|two|three|first|second|third)(?: (?:clip|one))?)"
_WAY = (
    r"(?:up|down|higher|lower|deeper|leftwards?|rightwards?|to the (?:left|right)|towards me"
    r"|away from me)"
)
_LENGTH = r"(?:(?:by )?[\d.,]+ ?(?:mm|cm|millimet(?:er|re)s?|centimet(?:er|re)s?))"
_ALIKE = tuple(  # one takes the place of another
    re.compile(rf"(?:\b(?:the|your) )?\b{one}\b") for one in (_TUBE, _ARM, _NUMBER, _WAY, _LENGTH)
)
_ORDERS = tuple(
    re.compile(rf".*\b{what}\b.*\b{of}\b.*|.*\b{of}\b.*\b{what}\b.*")
    for what, of in (
        (r"(?:clip|cut|divide|snip|transect|sever|first|second|third)", _TUBE),
        (r"(?:open|close|closed|shut)", _ARM),
        (rf"(?:{_WAY}|raise|lower|lift|drop)", _ARM),
    )
)
_JOINED = re.compile(r"[;,]|\b(?:and|then)\b")


def as_corrected(text: str) -> str:
    """Return a text in which the words that a person takes back are replaced by the right ones.

    Where it is not clear by what, the text says that it is sorry, which is no order.
    """
    halves = [half.strip(" ,.;:!") for half in _MENDS.split(text.lower())]
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
        return "" if _JOINED.search(wrong) else right
    for alike in _ALIKE:
        if alike.fullmatch(right) and len(alike.findall(wrong)) == 1:
            return alike.sub(right, wrong)
    return ""


def _orders(text: str) -> list[bool]:
    """Return which kinds of order a text has: deeds, jaws, motions; empty if it has none."""
    kinds = [pattern.fullmatch(text) is not None for pattern in _ORDERS]
    return kinds if any(kinds) else []
