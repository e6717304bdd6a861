"""From a sentence to what a person forbids, or allows again."""

from __future__ import annotations

import re

from planner.language.rules.phrase_lists import phrase_lists, whole_words
from planner.language.rules.plain_letters import in_plain_letters
from planner.person.prohibition import ACTS, Act, Prohibition

_CLAUSE = re.compile(r"[,;.!?:]|\bbut\b|\binstead\b")


def forbidden_in(text: str) -> Prohibition | None:
    """Return what an English sentence forbids; None if it names no act."""
    for clause in _CLAUSE.split(text.lower().replace("’", "'")):
        words = in_plain_letters(clause)
        never = _find(phrase_lists("forbidding")["who"]["never"], words)
        if never and (act := _act(words[never.end() :]) or _act(words)):
            return Prohibition(act=act, on=_on(act, words) or _on(act, in_plain_letters(text)))
    return None


def allowed_in(text: str) -> Prohibition | None:
    """Return what an English sentence allows again; None if it names no act."""
    words = in_plain_letters(text)
    act = _act(words) if _find(phrase_lists("forbidding")["who"]["may"], words) else None
    return Prohibition(act=act, on=_on(act, words)) if act else None


def _act(words: str) -> Act | None:
    """Return the act that is named first."""
    listed = phrase_lists("forbidding")["acts"]
    found = [
        (match.start(), k) for k, act in enumerate(ACTS) if (match := _find(listed[act], words))
    ]
    return ACTS[min(found)[1]] if found else None


def _find(phrases: tuple[str, ...], words: str) -> re.Match[str] | None:
    return whole_words(phrases).search(words)


def _on(act: Act, words: str) -> str:
    """Return which gripper or tube is named; "" for none."""
    lists, kind = phrase_lists("forbidding"), "gripper" if act == "open" else "tube"
    for name, phrases in lists[f"{kind}s"].items():
        if whole_words(phrases).search(words):
            return f"{name} {kind}" if name in ("left", "right") else name
    return ""
