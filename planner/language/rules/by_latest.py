"""An order that goes by the person's latest correction: "half that", "the other one", "more"."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Literal, TypeVar

from planner.command import COMMANDS
from planner.correction import Direction
from planner.language.reading import Relative, Said
from planner.language.rules.phrase_search import in_plain_letters
from planner.language.rules.sizes import echo_in, without_size

Name = TypeVar("Name", bound=str)

_ARM = r"(?:arm|hand|one|instrument|tool|gripper|side)"
_ARMS: dict[Literal["left", "right", "other"], str] = {
    "other": rf"(?:the )?other(?: {_ARM})?",
    "left": rf"(?:the )?left {_ARM}",
    "right": rf"(?:the )?right {_ARM}",
}
_WAYS: dict[Direction, str] = {
    "left": r"(?:to (?:the |my )?left|leftwards?)",
    "right": r"(?:to (?:the |my )?right|rightwards?)",
    "higher": r"(?:higher|up|upwards?|raise)",
    "lower": r"(?:lower|down|downwards?)",
    "away": r"(?:away(?: from me)?|deeper|inwards?|in|forwards?)",
    "towards": r"(?:towards? me|outwards?|out|shallower|closer)",
}
_TURNED = re.compile(
    r"\b(?:back the way (?:you|it) came|(?:the )?(?:way (?:you|it) came|other way|opposite(?: way"
    r"| direction)?|reverse)|back again|too (?:far|much)|overshot|the wrong way)\b"
)
_BACK = re.compile(r"\bback\b")
_MORE = re.compile(
    r"\b(?:more|again|once more|as well|too|also|another|further|farther|likewise|ditto|extra"
    r"|keep (?:coming|going)(?! on)|still|repeat|on top)\b"
)
_POINTS = re.compile(r"\b(?:this|that) way\b|^move\b", re.IGNORECASE)
_FILLERS = re.compile(
    r"\b(?:and|now|please|the|with|on|do|does|by|in|but|this time|just|then|of|an?|it|that|one"
    r"|ones|so|ok|okay|for|to|go|went|yes|yeah|only|you|can|could|come|me"
    r"|thing|amount|distance|way|first|time|get|same|take|us|let's|have|some)\b"
)


def by_latest(english: str) -> Said | None:
    """Return the order that a sentence gives by the latest correction; None if it gives none.

    Each of its words must be understood; one that warns or names an act never is.
    """
    text = in_plain_letters(english)
    echo = echo_in(text)
    text, times = (echo.text, echo.times) if echo else (text, 1.0)
    turned, text = bool(_TURNED.search(text)), _TURNED.sub(" ", text)
    size_m, measured = None, False
    if echo is None or times == 1.0:
        sized = without_size(text)
        more = bool(_MORE.search(text))
        text, size_m, measured = sized.text, sized.size_m, sized.measured
    else:
        more = True
    arm, text = _first(_ARMS, text)
    direction, text = _first(_WAYS, text)
    more = more or bool(_MORE.search(text))
    if _BACK.search(text) and direction is None and echo and echo.times != 1.0:
        turned = True
    if turned or direction:
        text = _BACK.sub(" ", text)
    if _FILLERS.sub(" ", _MORE.sub(" ", text)).strip():
        return None
    if _POINTS.search(english):
        return None
    refers = echo is not None or more or turned or arm == "other"
    small = size_m is not None and not measured and not (arm or direction)
    if not (refers or small) or (arm in ("left", "right") and direction and not echo):
        return None
    if not (echo or turned or arm or direction or size_m):
        return None  # "again"
    relative = Relative(times=times, arm=arm, direction="opposite" if turned else direction)
    if relative == Relative() and size_m is None:
        return None  # "the same again"
    return Said(command=COMMANDS["repeat"], size_m=size_m, relative=relative)


def _first(names: Mapping[Name, str], text: str) -> tuple[Name | None, str]:
    """Return which of the names a text has, and the text without it."""
    for name, said in names.items():
        if re.search(rf"\b{said}\b", text):
            return name, re.sub(rf"\b{said}\b", " ", text, count=1)
    return None, text
