"""Define the procedure's 17 tasks, in order, in the words of SRT-H (arXiv 2505.10251)."""

from dataclasses import dataclass
from typing import Literal

TaskKind = Literal["grab", "clip", "go_back", "cut", "go_back_from_cut"]
Tube = Literal["left", "right"]
RightTool = Literal["clip_applier", "scissors"]


@dataclass(frozen=True, kw_only=True)
class Task:
    """One step of the procedure.

    Attributes:
        index: Place in the procedure, 1 to 17.
        text: The words of a surgeon, unique to the task.
        kind: Kind of the task, for any tube and clip.
        tube: The tube of the task; None for grabbing.
        clip: Number of the clip on the tube, 1 to 3; None if the task has no clip.
        right_tool: The tool that the right arm must hold; the left arm always holds the grasper.
    """

    index: int
    text: str
    kind: TaskKind
    tube: Tube | None
    clip: int | None
    right_tool: RightTool

    @property
    def goes_back(self) -> bool:
        """Return whether the right arm only retracts, from a clip or from the cut."""
        return self.kind in ("go_back", "go_back_from_cut")

    @property
    def is_deed(self) -> bool:
        """Return whether the task is a clip or a cut, which cannot be undone."""
        return self.kind in ("clip", "cut")


def _tasks_of(tube: Tube, first_index: int) -> list[Task]:
    steps: list[tuple[str, TaskKind, int | None, RightTool]] = []
    for clip, ordinal in enumerate(("first", "second", "third"), start=1):
        steps.append((f"clipping {ordinal} clip", "clip", clip, "clip_applier"))
        steps.append((f"going back {ordinal} clip", "go_back", clip, "clip_applier"))
    steps.append(("go to the cutting position", "cut", None, "scissors"))
    steps.append(("go back from the cut", "go_back_from_cut", None, "scissors"))
    return [
        Task(
            index=index,
            text=f"{words} {tube} tube",
            kind=kind,
            tube=tube,
            clip=clip,
            right_tool=right_tool,
        )
        for index, (words, kind, clip, right_tool) in enumerate(steps, start=first_index)
    ]


TASKS: tuple[Task, ...] = (
    Task(
        index=1,
        text="grabbing gallbladder",
        kind="grab",
        tube=None,
        clip=None,
        right_tool="clip_applier",
    ),
    *_tasks_of("left", first_index=2),
    *_tasks_of("right", first_index=10),
)
GRAB = TASKS[0]

_BY_TEXT = {task.text: task for task in TASKS}


def task_from_text(text: str) -> Task:
    """Return the task with this text.

    Raises:
        ValueError: No task has this text; the message lists the 17 allowed texts.
    """
    try:
        return _BY_TEXT[text]
    except KeyError:
        raise ValueError(f"unknown task {text!r}; allowed: {', '.join(_BY_TEXT)}") from None
