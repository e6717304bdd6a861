"""What people say to a running episode, from any thread; the loop takes it in and never waits."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from queue import Empty, SimpleQueue

from planner.command import Command
from planner.instruction import Instruction
from planner.language.interpreter import Interpreter, Reading
from scenarios.script import Timed

LONGEST = 1000  # characters of a text that are kept; far beyond what is read as a command


@dataclass(frozen=True, kw_only=True)
class Heard:
    """What was said to an episode, and what came of it.

    Attributes:
        time_s: simulated, when it was taken in.
        instruction: in force because of it; None where it was not understood or was refused, which
            changes nothing.
        reply: in words, for the person.
    """

    time_s: float
    reading: Reading
    instruction: Instruction | None
    reply: str

    @property
    def text(self) -> str:
        """The words themselves."""
        return self.reading.text


@cache
def interpreter() -> Interpreter:
    """The one of this process; have it read a text early where the first must not be slow."""
    return Interpreter()


class Inbox:
    """A queue of readings. Texts are read in the thread that submits them, not in the loop."""

    def __init__(self) -> None:
        self._said: SimpleQueue[Reading] = SimpleQueue()
        self._arranged: deque[tuple[float, Reading]] = deque()

    def say(self, text: str) -> Reading:
        """Submit free text; returns how it is read, be it understood or asked back."""
        reading = _read(text)
        self._said.put(reading)
        return reading

    def press(self, command: Command) -> None:
        """Submit a command outright, as a button does."""
        self._said.put(
            Reading(
                text=command.text,
                command=command,
                guesses=(command,),
                confidence=1.0,
                by="button",
                reply=command.text,
            )
        )

    def arrange(self, script: Sequence[Timed]) -> None:
        """Have these come at their times; they replace what was arranged before."""
        ordered = sorted(script, key=lambda timed: timed.time_s)
        self._arranged = deque((timed.time_s, _read(timed.text)) for timed in ordered)

    def take(self, time_s: float) -> list[Reading]:
        """What is due at a moment of simulated time, then what was said since; each once."""
        taken = []
        while self._arranged and self._arranged[0][0] <= time_s + 1e-9:
            taken.append(self._arranged.popleft()[1])
        with suppress(Empty):
            while True:
                taken.append(self._said.get_nowait())
        return taken


def _read(text: str) -> Reading:
    return interpreter().read(text[:LONGEST])
