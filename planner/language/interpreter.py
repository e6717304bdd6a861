"""Free text to a reading: what was meant, or a question back."""

from __future__ import annotations

from dataclasses import dataclass

from planner.command import Command
from planner.language.grammar import read


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What a text was taken for.

    Attributes:
        command: what is meant; None when it is asked back.
        guesses: the likeliest commands, best first.
        confidence: 0 to 1.
        by: who read it.
        reply: in words, for the person.
    """

    text: str
    command: Command | None
    guesses: tuple[Command, ...]
    confidence: float
    by: str
    reply: str


class Interpreter:
    """Reads by the grammar alone."""

    def read(self, text: str) -> Reading:
        """What is meant by a text."""
        command = read(text)
        return Reading(
            text=text,
            command=command,
            guesses=(command,) if command else (),
            confidence=1.0 if command else 0.0,
            by="grammar",
            reply=command.text if command else "not understood: say it in other words",
        )
