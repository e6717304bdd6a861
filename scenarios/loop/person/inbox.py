"""People's words to a running episode, from any thread; the loop reads them without waiting."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from queue import Empty, SimpleQueue
from typing import TypeVar

from planner.command import COMMANDS, Command
from planner.instruction import Instruction
from planner.language.interpreter import Interpreter
from planner.language.reading import Reading
from scenarios.loop.person.guided_arm import GuidedArm
from scenarios.loop.person.script import Timed
from scenarios.perturbation.perturbation import Perturbation

T = TypeVar("T")

LONGEST = 1000  # characters of a text that is read; far beyond what is read as a command


@dataclass(frozen=True, kw_only=True)
class Heard:
    """A person's words to an episode, and their outcome.

    Attributes:
        time_s: Simulated time at which the loop read the text.
        instruction: The resulting instruction. None if the text was a question, was not understood
            or was refused, which changes nothing.
        reply: The answer in words, for the person.
    """

    time_s: float
    reading: Reading
    instruction: Instruction | None
    reply: str

    @property
    def text(self) -> str:
        """Return the words themselves."""
        return self.reading.text


@cache
def interpreter() -> Interpreter:
    """Return this process's interpreter; its first reading is slow."""
    return Interpreter()


def read(text: str) -> Reading:
    """Return the reading of any text; a text over the length limit holds the arms."""
    whole = text.encode("utf-8", "replace").decode()  # no output can show half a letter
    return too_long(whole) if len(whole) > LONGEST else interpreter().read(whole)


def too_long(text: str) -> Reading:
    """Return the reading of a text of which only the beginning is read: the rest may say stop."""
    return Reading(
        text=text[:LONGEST],
        command=COMMANDS["stop"],
        confidence=1.0,
        by="warning",
        reply=f"Longer than {LONGEST} characters: too long to read.",
    )


class Inbox:
    """A queue of readings. Texts are read in the thread that submits them, not in the loop.

    Attributes:
        guided: The arm that a person leads now, and its goal.
    """

    def __init__(self) -> None:
        self._said: SimpleQueue[Reading] = SimpleQueue()
        self._arranged: deque[tuple[float, Reading]] = deque()
        self._disturbances: SimpleQueue[Perturbation] = SimpleQueue()
        self.guided: GuidedArm | None = None

    def say(self, text: str) -> Reading:
        """Submit free text; return its reading, whether understood or asked back."""
        reading = read(text)
        self.put(reading)
        return reading

    def put(self, reading: Reading) -> None:
        """Submit a text that was already read."""
        self._said.put(reading)

    def press(self, command: Command) -> None:
        """Submit a command directly, as a button does."""
        self.put(
            Reading(
                text=command.text,
                command=command,
                confidence=1.0,
                by="button",
                reply=command.text,
            )
        )

    def disturb(self, perturbation: Perturbation) -> None:
        """Submit a perturbation."""
        self._disturbances.put(perturbation)

    def disturbances(self) -> list[Perturbation]:
        """Return the perturbations submitted since the last call."""
        return _drained(self._disturbances)

    def arrange(self, script: Sequence[Timed]) -> None:
        """Schedule texts at their times; they replace an earlier schedule."""
        ordered = sorted(script, key=lambda timed: timed.time_s)
        self._arranged = deque((timed.time_s, read(timed.text)) for timed in ordered)

    def take(self, time_s: float) -> list[Reading]:
        """Return the scheduled readings due at a simulated time, then the submitted; each once."""
        taken = []
        while self._arranged and self._arranged[0][0] <= time_s + 1e-9:
            taken.append(self._arranged.popleft()[1])
        return taken + _drained(self._said)


def _drained(queue: SimpleQueue[T]) -> list[T]:
    """Return everything in the queue, without waiting."""
    taken = []
    with suppress(Empty):
        while True:
            taken.append(queue.get_nowait())
    return taken
