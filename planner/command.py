"""Everything a person may mean by what is said: an instruction, or a word about the run itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Literal

from planner.correction import CORRECTIONS, Correction
from planner.task import TASKS, Task, Tube

Word = Literal["stop", "pause", "resume", "repeat", "undo", "next step", "let go"]
Structure = Literal["duct", "artery"]
Deed = Literal["clip", "cut"]
STRUCTURES: tuple[Structure, ...] = ("duct", "artery")
TUBES: tuple[Tube, ...] = ("left", "right")
DEEDS: tuple[Deed, ...] = ("clip", "cut")
WORDS: tuple[Word, ...] = ("stop", "pause", "resume", "repeat", "undo", "next step", "let go")


@dataclass(frozen=True, kw_only=True)
class Command:
    """What is meant; one of the attributes beside the text says what kind it is.

    Attributes:
        text: in words, unique to the command.
        task: to go on with; where a structure is named, as of the left tube.
        correction: to make.
        word: about the run.
        deed: to do, the next that is due on the tube; which clip it is was not said.
        tube: of a deed, as the endoscope sees it.
        structure: said in the tube's place, of a deed or of a task.
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
        """Whether the robot may move by it."""
        return self.word not in ("stop", "pause")

    def seen(self, duct: Tube) -> Command:
        """The same of the tube that a structure is in view, where `duct` is the duct's."""
        if self.structure is None:
            return self
        tube = next(one for one in TUBES if (one == duct) == (self.structure == "duct"))
        return COMMANDS[self.text.replace(self.structure, f"{tube} tube")]


def _of_structures() -> Iterator[Command]:
    """Tasks on the left tube, with a structure said in its place."""
    for task, structure in product(TASKS, STRUCTURES):
        if task.tube == "left":
            text = task.text.replace("left tube", structure)
            yield Command(text=text, task=task, structure=structure)


def _deeds() -> Iterator[Command]:
    for deed in DEEDS:
        for structure in STRUCTURES:
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
"""By their texts."""
