"""What people say to a running episode, from any thread; the loop takes it in and never waits."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from queue import Empty, SimpleQueue
from typing import TypeVar

from planner.command import Command
from planner.instruction import Instruction
from planner.language.interpreter import Interpreter, Reading
from scenarios.loop.guided_arm import GuidedArm
from scenarios.loop.script import Timed
from scenarios.perturbation.perturbation import Perturbation

T = TypeVar("T")

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


def read(text: str) -> Reading:
    """How a text is taken; of a very long one, its beginning."""
    return interpreter().read(text[:LONGEST])


class Inbox:
    """A queue of readings. Texts are read in the thread that submits them, not in the loop.

    Attributes:
        hand: a person's, while it leads an arm.
    """

    def __init__(self) -> None:
        self._said: SimpleQueue[Reading] = SimpleQueue()
        self._arranged: deque[tuple[float, Reading]] = deque()
        self._disturbances: SimpleQueue[Perturbation] = SimpleQueue()
        self.hand: GuidedArm | None = None

    def say(self, text: str) -> Reading:
        """Submit free text; returns how it is read, be it understood or asked back."""
        reading = read(text)
        self.put(reading)
        return reading

    def put(self, reading: Reading) -> None:
        """Submit what was read already."""
        self._said.put(reading)

    def press(self, command: Command) -> None:
        """Submit a command outright, as a button does."""
        self.put(
            Reading(
                text=command.text,
                command=command,
                guesses=(command,),
                confidence=1.0,
                by="button",
                reply=command.text,
            )
        )

    def disturb(self, perturbation: Perturbation) -> None:
        """Submit something that is to go wrong."""
        self._disturbances.put(perturbation)

    def disturbances(self) -> list[Perturbation]:
        """Those submitted since; each once."""
        return _drained(self._disturbances)

    def arrange(self, script: Sequence[Timed]) -> None:
        """Have these come at their times; they replace what was arranged before."""
        ordered = sorted(script, key=lambda timed: timed.time_s)
        self._arranged = deque((timed.time_s, read(timed.text)) for timed in ordered)

    def take(self, time_s: float) -> list[Reading]:
        """What is due at a moment of simulated time, then what was said since; each once."""
        taken = []
        while self._arranged and self._arranged[0][0] <= time_s + 1e-9:
            taken.append(self._arranged.popleft()[1])
        return taken + _drained(self._said)


def _drained(queue: SimpleQueue[T]) -> list[T]:
    """All that is in it, without waiting."""
    taken = []
    with suppress(Empty):
        while True:
            taken.append(queue.get_nowait())
    return taken
