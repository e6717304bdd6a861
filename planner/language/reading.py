"""How a text was understood."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from planner.command import Command
from planner.correction import Direction
from planner.language.rules.questions import Question, Thing
from planner.person.premises import Claim
from planner.person.prohibition import Prohibition
from tissue_sim.patient.tube_names import Tube

Applier = Literal["slim", "large", "other"]
By = Literal["grammar", "classifier", "button", "warning", "rule", "nobody"]


@dataclass(frozen=True, kw_only=True)
class Relative:
    """How a correction differs from a person's latest one: "half that", "the other one".

    Attributes:
        times: How many times as far it goes, where no size is said.
        arm: That makes it; None for the same.
        direction: The way that it goes; None for the same.
    """

    times: float = 1.0
    arm: Literal["left", "right", "other"] | None = None
    direction: Direction | Literal["opposite"] | None = None

    @property
    def text(self) -> str:
        """Return it in words: "the same with the other arm, 0.5 times as far"."""
        arm = self.arm and f" with the {self.arm} arm"
        way = self.direction and f", direction {self.direction}"
        times = "" if self.times == 1.0 else f", {self.times:.2g} times as far"
        return f"the same{arm or ''}{way or ''}{times}"


@dataclass(frozen=True, kw_only=True)
class Said:
    """A command, and what was said with it.

    Attributes:
        size_m: How far a correction goes; None if nobody said.
        side: Where a structure is said to be, "the left duct"; None if it is named alone.
        relative: With "repeat": how it differs from the latest correction; None for that order.
    """

    command: Command
    size_m: float | None = None
    side: Tube | None = None
    relative: Relative | None = None

    @property
    def text(self) -> str:
        """Return it in words: "move left arm higher by 2 mm"."""
        size = "" if self.size_m is None else f" by {1e3 * self.size_m:g} mm"
        return f"{self.relative.text if self.relative else self.command.text}{size}"


@dataclass(frozen=True, kw_only=True)
class Reading:
    """How a text was understood.

    Attributes:
        text: As it was said.
        command: The meaning; None if it is not clear, or no command. A warning means "stop".
        size_m: How far a correction goes; None if nobody said.
        side: Where a structure is said to be; None if it is named alone.
        relative: How a correction differs from the latest one; None if it does not refer to it.
        then: Further commands, in order.
        forbids: What a person forbids from now on.
        allows: What a person may allow with these words, if it was forbidden.
        may_allow: What they may mean to allow; it is asked back, and nothing is lifted.
        claims: What they take for done or so, true or not: "the duct is cut, go back".
        speed: "slower", "faster", "half" or "normal"; "" if it is not about speed.
        applier: The clip applier to use; "other" is the one that is not mounted. None if not said.
        question: What is asked.
        about: What they are about; None if they name no structure, tool or clip.
        agrees: It says yes to what was asked back.
        guesses: What may be meant, the likeliest first; empty if there is a command but no warning.
        confidence: Of the command, or of the first guess, 0 to 1.
        by: What found the command.
        reply: To the person, one line, which says nothing of what the arms do: the reader of the
            text does not know that.
    """

    text: str
    command: Command | None = None
    size_m: float | None = None
    side: Tube | None = None
    relative: Relative | None = None
    then: tuple[Said, ...] = ()
    forbids: tuple[Prohibition, ...] = ()
    allows: Prohibition | None = None
    may_allow: Prohibition | None = None
    claims: tuple[Claim, ...] = ()
    speed: str = ""
    applier: Applier | None = None
    question: Question | None = None
    about: Thing | None = None
    agrees: bool = False
    guesses: tuple[Said, ...] = ()
    confidence: float = 0.0
    by: By = "nobody"
    reply: str

    @property
    def said(self) -> tuple[Said, ...]:
        """Return the command with what was said with it, and those that follow; empty if none."""
        if self.command is None:
            return ()
        first = Said(
            command=self.command, size_m=self.size_m, side=self.side, relative=self.relative
        )
        return (first, *self.then)
