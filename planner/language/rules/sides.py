"""A structure's side that is said with it: "the left duct". It must agree with what is seen."""

from __future__ import annotations

import re

from planner.task import Tube

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
