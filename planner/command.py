"""Everything a person may mean by what is said: an instruction, or a word about the run itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from planner.correction import CORRECTIONS, Correction
from planner.task import TASKS, Task, Tube

Word = Literal["stop", "pause", "resume", "repeat", "undo", "next step", "let go"]
Structure = Literal["duct", "artery"]
Deed = Literal["clip", "cut"]
WORDS: tuple[Word, ...] = ("stop", "pause", "resume", "repeat", "undo", "next step", "let go")


@dataclass(frozen=True, kw_only=True)
class Command:
    """What is meant; one of the attributes beside the text says what kind it is.

    Attributes:
        text: in words, unique to the command.
        task: to go on with.
        correction: to make.
        word: about the run.
        deed: to do on `where`, the next that is due there; which clip it is was not said.
        where: a tube as the endoscope sees it, or a structure.
    """

    text: str
    task: Task | None = None
    correction: Correction | None = None
    word: Word | None = None
    deed: Deed | None = None
    where: Tube | Structure | None = None

    @property
    def moves(self) -> bool:
        """Whether the robot may move by it."""
        return self.word not in ("stop", "pause")


def _deeds() -> list[Command]:
    places: tuple[tuple[Tube | Structure, str], ...] = (
        ("duct", "duct"), ("artery", "artery"), ("left", "left tube"), ("right", "right tube"),
    )  # fmt: skip
    deeds: tuple[Deed, ...] = ("clip", "cut")
    return [
        Command(text=f"{deed} {words}", deed=deed, where=where)
        for deed in deeds
        for where, words in places
    ]


COMMANDS: dict[str, Command] = {
    command.text: command
    for command in (
        *(Command(text=task.text, task=task) for task in TASKS),
        *(Command(text=c.text, correction=c) for c in CORRECTIONS),
        *_deeds(),
        *(Command(text=word, word=word) for word in WORDS),
    )
}
"""By their texts."""
