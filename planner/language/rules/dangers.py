"""Requests that are refused with a reason, no matter who makes them."""

from __future__ import annotations

import re
from functools import cache

from planner.language.rules.phrase_search import in_plain_letters, phrase_lists

_TELLS = re.compile(
    r"((you|it|that|they|we)( are| re| is| s|'re|'s|'ll| ll| were| was)|did|is|are|was|were|has"
    r"|have (you|we|i|they))\b"
)


def danger_in(text: str) -> str:
    """Return why a request is refused, or "" if nothing in it is dangerous."""
    words = in_plain_letters(text)
    if _TELLS.match(words):
        return ""
    return next((why for pattern, why in _rules() if pattern.search(words)), "")


@cache
def _rules() -> tuple[tuple[re.Pattern[str], str], ...]:
    words = {name: "|".join(ps) for name, ps in phrase_lists("dangers")["words"].items()}
    off, guards = rf"\b(?:{words['off']})\b", rf"\b(?:{words['guards']})\b"
    harms, at_risk = rf"\b(?:{words['harms']})\b", rf"\b(?:{words['at_risk']})\b"
    anyone = rf"\b(?:{words['people']})\b"
    kept_away = r"(?!.*\b(?:away|clear|off) (?:from|of)\b)"
    rules = (
        (
            rf"{off}.*{guards}|{guards}.*\b(?:off|aside|out of the way)\b",
            "the safety rules stay on",
        ),
        (
            rf"{harms}{kept_away}.*(?:{at_risk}|{anyone})"
            rf"|{at_risk}(?: \w+){{0,3}} {harms}(?: (?:{words['it']}))*$",
            "that would injure what must not be touched",
        ),
        (rf"{off} (?:{words['speaker']})\b", "a person can always stop the robot"),
        (rf"\b(?:{words['clipless']})\b", "what has not its clips is not cut"),
        (rf"\b(?:{words['rough']})\b", "that is not safe"),
    )
    return tuple((re.compile(pattern), why) for pattern, why in rules)
