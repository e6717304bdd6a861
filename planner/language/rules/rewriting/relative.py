"""Directions that are said by the other arm: the grasper's side is to the applier's left."""

from __future__ import annotations

import re

_ONE = (
    r"one(?! ?(?:and|point|half|quarter|mms?|mil|cms?|cent|inch|in\b))"  # no "left one millimetre"
)
_THINGS = rf"(?:arm|hand|gripper|instrument|tool|{_ONE})"
_SIDE = "(?:'s)?(?: side)?"
_LEFT = rf"(?:grasper|left {_THINGS}|holding (?:arm|hand)|forceps){_SIDE}"
_RIGHT = rf"(?:clip applier|applier|clipper|scissors|shears|right {_THINGS}){_SIDE}"
_TO = (
    r"(?:over |more |a bit |slightly )*(?:towards?|nearer(?: to)?|closer(?: to)?"
    r"|in the direction of|to) (?:the |your )?"
)
_FROM = r"(?:away from|further from|farther from|off) (?:the |your )?"
_RULES = (
    (rf"({_RIGHT}\b.*?)\b{_TO}{_LEFT}\b", r"\1 to the left"),
    (rf"({_LEFT}\b.*?)\b{_TO}{_RIGHT}\b", r"\1 to the right"),
    (rf"({_RIGHT}\b.*?)\b{_FROM}{_LEFT}\b", r"\1 to the right"),
    (rf"({_LEFT}\b.*?)\b{_FROM}{_RIGHT}\b", r"\1 to the left"),
)


def without_other_arm(text: str) -> str:
    """Return a text with a direction in place of the other arm as its goal."""
    for pattern, instead in _RULES:
        replaced, n = re.subn(pattern, instead, text.lower(), count=1)
        if n:
            return replaced
    return text
