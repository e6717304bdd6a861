"""How fast the arms may move: "slower", "half speed", "normal speed"."""

from __future__ import annotations

import re

from planner.language.rules.phrase_lists import phrase_lists, whole_words
from planner.language.rules.plain_letters import in_plain_letters

_LINK = re.compile(r"[ ,]*\b(at|with|in|and|but|a bit|a little|much)? *$")


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
    before = _LINK.sub("", words[: found.start()])
    return f"{before} {words[found.end() :].lstrip(' ,')}".strip()


def _found(words: str) -> tuple[str, re.Match[str] | None]:
    lists = phrase_lists("speeds")["speeds"]
    found = ((speed, whole_words(ps).search(words)) for speed, ps in lists.items())
    return next(((speed, at) for speed, at in found if at), ("", None))
