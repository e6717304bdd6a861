"""Decide where the kind head reads a text besides the rules, or instead of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING
from unicodedata import normalize

from planner.command import COMMANDS
from planner.language.reading import Reading
from planner.language.rules.claims import claims_in
from planner.language.rules.questions import QUESTIONS, asks_plainly, question_in
from planner.language.rules.small_talk import is_small_talk
from planner.language.rules.warning import warns, warns_mildly

if TYPE_CHECKING:
    from planner.language.kind_head import Kind

MAX_CHARACTERS = 200  # longer texts are not understood
STOP, PAUSE = COMMANDS["stop"], COMMANDS["pause"]


def kind_besides(ruled: Reading, english: str, danger: str) -> tuple[Kind | None, bool]:
    """Return what a text may be besides what rules read, and whether that is sure.

    None where rules are not in doubt. No order but to clip or cut is overruled.
    """
    text, order, warned = ruled.text, ruled.command, ruled.by == "warning"
    stops = order in (STOP, PAUSE) and not (warns(text) or warns(english))  # "freezing"
    ordered = order is not None and not (order.deed or warned or stops)
    plain = ruled.question is not None and asks_plainly(english)
    if ordered or plain or ruled.agrees or ruled.speed or ruled.applier or (warned and danger):
        return None, False
    from planner.language.kind_head import (  # PyTorch: seconds, once
        LETS_ACT,
        chances,
        kind_in,
        kind_instead,
    )

    found = chances(text)
    sure = kind_instead(found)
    confirmed = sure not in ("allow", "resume") or kind_instead(found, LETS_ACT) == sure
    if warned:
        return _instead_of_warning(ruled, english, found)
    if stops:
        return (sure if sure in (*QUESTIONS, "none") else None), True
    if ruled.question:
        return sure, confirmed
    if order:
        return (sure if sure in ("hold", "forbid") else None), True
    if trouble_in(text, english):
        return None, False
    told = bool(ruled.guesses or claims_in(english))  # a claim is compared with what is seen
    kind = kind_in(found, guessed=told or bool(danger))
    holds = kind in ("hold", "forbid")
    unlike = is_small_talk(english) if holds else danger
    return None if unlike else kind, kind == sure and confirmed


def _instead_of_warning(
    ruled: Reading, english: str, found: Mapping[Kind, float]
) -> tuple[Kind | None, bool]:
    """Return what a text says that rules take for a warning, and whether that is sure.

    Where they hear a ban or a grave word and the head a permission, it may be either.
    """
    from planner.language.kind_head import LETS_ACT, kind_instead

    calm = kind_instead(found)
    if calm == "forbid":
        return (None if ruled.guesses else "forbid"), True  # "no, clip the duct" means to clip
    if ruled.forbids or not (warns_mildly(ruled.text) and warns_mildly(english)):
        return (calm if calm == "allow" else None), False
    if calm == "resume":
        return kind_instead(found, LETS_ACT), True
    return (calm if calm in (*QUESTIONS, "none", "allow") else None), calm != "allow"


def trouble_in(text: str, english: str) -> str:
    """Return why a text cannot be read at all; empty if it can."""
    if not text.strip():
        return "nothing was said"
    if len(text) > MAX_CHARACTERS:
        return f"it is longer than {MAX_CHARACTERS} characters"
    foreign = any(one.isalpha() and not one.isascii() for one in normalize("NFKC", english))
    if foreign and question_in(english) is None:
        return "it is in no language that is understood"
    return ""
