"""An order that goes by the person's latest correction: "half that", "the other one", "more"."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Literal, TypeVar

from planner.command import COMMANDS
from planner.correction import Direction
from planner.language.reading import Relative, Said
from planner.language.rules.phrase_search import in_plain_letters, patterns
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
_RE = patterns("by_latest")


def by_latest(english: str) -> Said | None:
    """Return the order that a sentence gives by the latest correction; None if it gives none.

    Each of its words must be understood; one that warns or names an act never is.
    """
    text = in_plain_letters(english)
    echo = echo_in(text)
    text, times = (echo.text, echo.times) if echo else (text, 1.0)
    turned, text = bool(_RE["turned"].search(text)), _RE["turned"].sub(" ", text)
    size_m, measured = None, False
    if echo is None or times == 1.0:
        sized = without_size(text)
        more = bool(_RE["more"].search(text))
        text, size_m, measured = sized.text, sized.size_m, sized.measured
    else:
        more = True
    arm, text = _first(_ARMS, text)
    direction, text = _first(_WAYS, text)
    more = more or bool(_RE["more"].search(text))
    if _RE["back"].search(text) and direction is None and echo and echo.times != 1.0:
        turned = True
    if turned or direction:
        text = _RE["back"].sub(" ", text)
    if _RE["fillers"].sub(" ", _RE["more"].sub(" ", text)).strip():
        return None
    if _RE["points"].search(english):
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
