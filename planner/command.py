"""Define every command that a person can give: an instruction, or a word about the run itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Literal

from planner.correction import CORRECTIONS, Correction
from planner.procedure.cholecystectomy import TASKS
from planner.procedure.task import Task
from tissue_sim.patient.tube_names import (
    TUBES,
    USUAL_STRUCTURES,
    Structure,
    Tube,
    tube_where,
)

Word = Literal["stop", "pause", "resume", "repeat", "undo", "next step", "let go"]
Deed = Literal["clip", "cut"]
DEEDS: tuple[Deed, ...] = ("clip", "cut")
WORDS: tuple[Word, ...] = ("stop", "pause", "resume", "repeat", "undo", "next step", "let go")


@dataclass(frozen=True, kw_only=True)
class Command:
    """The meaning of a sentence. Exactly one of task, correction, word and deed is set.

    Attributes:
        text: The command in words, unique to the command.
        task: Task to carry out. If a structure is named, it is the task on the left tube.
        correction: Correction to make.
        word: Word about the run.
        deed: The next clip, or the cut, on the tube; the person did not name the clip.
        tube: Tube of a deed, as the endoscope shows it.
        structure: Structure that is named instead of the tube, in a deed or in a task.
    """

    text: str
    task: Task | None = None
    correction: Correction | None = None
    word: Word | None = None
    deed: Deed | None = None
    tube: Tube | None = None
    structure: Structure | None = None

    @property
    def moves(self) -> bool:
        """Return whether the command may move the robot."""
        return self.word not in ("stop", "pause")

    def seen(self, duct: Tube) -> Command:
        """Return the command with the structure replaced by its tube; `duct` is the duct's tube."""
        if self.structure is None:
            return self
        tube = tube_where(self.structure, duct)
        return COMMANDS[self.text.replace(self.structure, f"{tube} tube")]


def _of_structures() -> Iterator[Command]:
    """Yield the tasks on the left tube with a structure named instead of the tube."""
    for task, structure in product(TASKS, USUAL_STRUCTURES):
        if task.tube == "left":
            text = task.text.replace("left tube", structure)
            yield Command(text=text, task=task, structure=structure)


def _deeds() -> Iterator[Command]:
    for deed in DEEDS:
        for structure in USUAL_STRUCTURES:
            yield Command(text=f"{deed} {structure}", deed=deed, structure=structure)
        for tube in TUBES:
            yield Command(text=f"{deed} {tube} tube", deed=deed, tube=tube)


COMMANDS: dict[str, Command] = {
    command.text: command
    for command in (
        *(Command(text=task.text, task=task) for task in TASKS),
        *_of_structures(),
        *(Command(text=c.text, correction=c) for c in CORRECTIONS),
        *_deeds(),
        *(Command(text=word, word=word) for word in WORDS),
    )
}
"""Every command by its text."""
