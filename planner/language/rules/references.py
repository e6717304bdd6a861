"""Find which clip or structure is meant where it is said at length, or with its side.

Examples are "third and last one", several clips one by one, and "the left duct". A side must agree
with what is seen.
"""

from __future__ import annotations

import re

from planner.procedure.task import Tube

_NTH = r"(first|second|third|1st|2nd|3rd)"
_RULES = (
    (r"\b(?:hem|haem)-?o-?loks?\b|\b(?:liga|hemo|haemo|endo)-?clips?\b", "clip"),
    (rf"\b{_NTH},? and (?:last|final)(?: one| clip)?\b,?", r"\1 clip"),
    (rf"\b{_NTH} of (?:the |its |your |those )?(?:three )?clips?\b", r"\1 clip"),
    (rf"\ba clip\b(.*?),? (?:and )?(?:that(?:'ll| will|'d)? be|that(?:'s| is)|it'?ll be|making it)"
     rf" (?:the |number )?{_NTH}(?: one| clip)?(?=$|[.!])", r"\2 clip\1"),
    (rf"\b{_NTH} (duct|artery) clip\b", r"\1 clip on \2"),
    (r"\b(duct|artery) clip (?:number |no\.? )?(one|two|three|1|2|3)\b(?! ?(?:mm|mil|cm|cent))",
     r"clip \2 on \1"),
)  # fmt: skip
_ONE = r"(?:number |no\.? )?(one|two|three|1|2|3)"
_AND = r"(?:,? (?:and|plus|then|&) |, )"
_CLIPS = re.compile(
    rf"^(.*?)(?:\bclips? {_ONE}(?:, {_ONE})?{_AND}(?:clip )?{_ONE}"
    rf"|\b{_NTH}(?:, {_NTH})?{_AND}(?:the )?{_NTH} clips?)\b(?! ?(?:mm|mil|cm|cent))"
    r"(.*?)(?=,|;| and | then |$)"
)


def clip_by_clip(text: str) -> str:
    """Return a lower-case text in which each of several clips has its own part."""
    if not (found := _CLIPS.search(text)):
        return text
    before, *clips, after = (group for group in found.groups() if group is not None)
    each = (f"{before}clip {number}{after}" for number in clips)
    return ", then ".join(each) + text[found.end() :]


def with_plain_ordinals(text: str) -> str:
    """Return a text in which a clip's number stands before it."""
    for pattern, instead in _RULES:
        text = re.sub(pattern, instead, text, flags=re.IGNORECASE)
    return text


_SIDED = re.compile(
    r"\b(?P<side>left|right)(?:[- ]?(?:hand(?:ed)?(?:[- ]?side)?|sided?))? (?:cystic )?"
    r"(?P<what>duct|artery|docked|dukt)\b"
)
_ON_SIDE = re.compile(
    r"\b(?P<what>duct|artery|docked|dukt)(?:,| which is|,? on| at| to)* (?:the |your |my )?"
    r"(?P<side>left|right)(?:[- ]hand)?(?:[- ]side)?(?! (?:arm|hand|gripper|tube))\b"
)


def without_side(text: str) -> tuple[str, Tube | None]:
    """Return a text with the side of a structure taken out, and that side."""
    for pattern in (_SIDED, _ON_SIDE):
        if found := pattern.search(text.lower()):
            side: Tube = "left" if found["side"] == "left" else "right"
            return pattern.sub(r"\g<what>", text.lower(), count=1), side
    return text, None
