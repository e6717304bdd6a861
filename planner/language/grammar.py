"""What the words say outright: slots from a lexicon, and the one command that they fill.

A reading stands only when every word is accounted for and no slot is filled twice.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from difflib import get_close_matches

from planner.command import COMMANDS, Command
from planner.correction import CORRECTIONS
from planner.language.lexicon import LEXICON, LONGEST, Sense
from planner.task import TASKS

OPPOSITE = {
    "left": "right", "right": "left", "higher": "lower", "lower": "higher",
    "away": "towards", "towards": "away", "open": "close", "close": "open",
}  # fmt: skip
_MOST_CHARACTERS = 200
_ASKS = re.compile(
    r"^(what|why|who|whose|when|where|which|how|is|are|was|were|do|does|did|am|has|have|should)\b"
)
_WORDS = sorted({word for phrase in LEXICON for word in phrase.split() if len(word) > 3})
_CLOSE = 0.82  # of difflib's ratio: one letter in five


def normalised(text: str) -> str:
    """Lower case, plain letters, single spaces; numbers and their units go."""
    plain = unicodedata.normalize("NFKC", text).lower().replace("’", "'")
    plain = re.sub(r"\d+([.,]\d+)?\s*(mm|cm|millimet\w+|centimet\w+)", " ", plain)
    return " ".join(re.sub(r"[^a-z0-9' ]+", " ", plain).split())


def read(text: str) -> Command | None:
    """The command that a sentence spells out; None when it does not."""
    if len(text) > _MOST_CHARACTERS or not text.isprintable():
        return None
    words = normalised(text)
    if not words or (text.rstrip().endswith("?") and _ASKS.match(words)) or _ASKS.match(words):
        return None
    senses = list(_senses(words.split()))
    if any(sense is None for sense in senses):
        return None
    slots: dict[str, set[str]] = {}
    for sense in senses:
        if sense is not None and sense.slot != "filler":
            slots.setdefault(sense.slot, set()).add(sense.value)
    return _command(slots)


def _senses(words: list[str]) -> Iterator[Sense | None]:
    """Of the longest phrases, from the first word on; None for a word that is not known."""
    k = 0
    while k < len(words):
        for n in range(min(LONGEST, len(words) - k), 0, -1):
            if sense := LEXICON.get(" ".join(words[k : k + n])):
                yield sense
                k += n
                break
        else:
            yield _misspelt(words[k])
            k += 1


def _misspelt(word: str) -> Sense | None:
    near = get_close_matches(word, _WORDS, n=1, cutoff=_CLOSE) if len(word) > 3 else []
    return LEXICON.get(near[0], Sense("filler", "")) if near else None


def _command(slots: dict[str, set[str]]) -> Command | None:
    if any(len(values) > 1 for values in slots.values()):
        return None
    one = {slot: next(iter(values)) for slot, values in slots.items()}
    if "not" in one:
        return None
    if "word" in one:
        return COMMANDS[one["word"]] if len(one) == 1 else None
    if "too" in one:
        for slot in ("direction", "jaw"):
            if slot in one:
                one[slot] = OPPOSITE[one[slot]]
    if "deed" in one:
        return _task(one)
    return _correction(one)


def _correction(one: dict[str, str]) -> Command | None:
    arm = one.get("gripper") or one.get("arm")
    meant = [
        c
        for c in CORRECTIONS
        if (c.arm, c.direction, c.jaw) == (arm, one.get("direction"), one.get("jaw"))
    ]
    return COMMANDS[meant[0].text] if meant else None


def _task(one: dict[str, str]) -> Command | None:
    tube, clip, deed = one.get("tube"), one.get("ordinal"), one["deed"]
    if deed in ("clip", "cut") and clip is None:
        where = one.get("structure") or (f"{tube} tube" if tube else None)
        return COMMANDS.get(f"{deed} {where}")
    kind = {"cut_position": "cut", "clip": "clip", "grab": "grab"}.get(deed, deed)
    if deed == "back":
        kind = "go_back_from_cut" if "from_cut" in one else "go_back"
    wanted = (kind, tube, int(clip) if clip else None)
    meant = [t for t in TASKS if (t.kind, t.tube, t.clip) == wanted]
    return COMMANDS[meant[0].text] if len(meant) == 1 else None
