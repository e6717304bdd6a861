"""From free text to a command or a question back; a misunderstood sentence moves nothing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal
from unicodedata import normalize

from planner.command import Command
from planner.language.grammar import Parse, may_be_filled, openness, parse
from planner.language.phrases import normalised
from planner.language.slot_heads import SlotHeads, load
from planner.language.slots import spelt_out

MAX_CHARACTERS = 200
MAX_GUESSES = 3
MIN_CHANCE = 0.05  # probability of a guess worth offering; assumed
_UNLISTED = "qqqq the left arm higher"

By = Literal["grammar", "classifier", "button", "nobody"]


@dataclass(frozen=True, kw_only=True)
class Reading:
    """How a text was understood.

    Attributes:
        text: As it was said.
        command: The meaning; None if it is not clear.
        guesses: Possible commands, the likeliest first; empty if there is a command.
        confidence: Of the command, or of the first guess, 0 to 1.
        by: What found the command.
        reply: To the person, one line.
    """

    text: str
    command: Command | None = None
    guesses: tuple[Command, ...] = ()
    confidence: float = 0.0
    by: By = "nobody"
    reply: str


class Interpreter:
    """Reads free text; it loads the sentence encoder when a sentence first needs it."""

    def read(self, text: str) -> Reading:
        """Return the meaning of any text; never raise."""
        if trouble := _trouble(text):
            return _not_understood(text, trouble)
        parsed = parse(text)
        if parsed.refusal:
            return _not_understood(text, parsed.refusal)
        command = spelt_out(parsed.filled)
        if command and not (parsed.unknown and command.moves):
            return _understood(text, command, 1.0, "grammar")
        return self._guess(text, parsed)

    def warm_up(self) -> None:
        """Load the sentence encoder, so that the first unknown word does not wait for seconds."""
        self.read(_UNLISTED)

    @cached_property
    def _heads(self) -> SlotHeads:
        return load()

    def _guess(self, text: str, parsed: Parse) -> Reading:
        from planner.language.sentence_encoder import embed  # PyTorch: seconds, once

        if not parsed.filled:
            return _not_understood(text, "no word of it names a motion, a clip, a cut or a side")
        ranked = self._heads.ranked(embed(normalised(text)).numpy(), parsed.filled)
        confidence, best = ranked[0] if ranked else (0.0, None)
        sure = self._heads.thresholds[openness(parsed)]
        if best and confidence >= sure and may_be_filled(parsed, best):
            return _understood(text, best, confidence, "classifier")
        guesses = tuple(c for chance, c in ranked[:MAX_GUESSES] if chance >= MIN_CHANCE)
        return _asked_back(text, guesses, confidence)


def _trouble(text: str) -> str:
    """Return why a text cannot be read at all; empty if it can."""
    if not text.strip():
        return "nothing was said"
    if len(text) > MAX_CHARACTERS:
        return f"it is longer than {MAX_CHARACTERS} characters"
    if not text.strip().isprintable():
        return "it has characters that cannot be read"
    if any(one.isalpha() and not one.isascii() for one in normalize("NFKC", text)):
        return "it is not in English"
    return ""


def _understood(text: str, command: Command, confidence: float, by: By) -> Reading:
    reply = f"Understood: {command.text}."
    return Reading(text=text, command=command, confidence=confidence, by=by, reply=reply)


def _not_understood(text: str, why: str) -> Reading:
    return Reading(text=text, reply=f"Not understood: {why}. Nothing moves.")


def _asked_back(text: str, guesses: tuple[Command, ...], confidence: float) -> Reading:
    if not guesses:
        return _not_understood(text, "it may mean too many things, or none")
    meant = " or ".join(f'"{guess.text}"' for guess in guesses)
    reply = f"Did you mean {meant}? Nothing moves."
    return Reading(text=text, guesses=guesses, confidence=confidence, reply=reply)
