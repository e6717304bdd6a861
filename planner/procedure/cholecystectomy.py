"""List the tasks of the clipping-and-cutting step of a cholecystectomy (arXiv 2505.10251).

The first 17 tasks and their words are those of SRT-H. A patient with a second artery has eight more
tasks, in the same words: those of the third tube.
"""

from __future__ import annotations

from collections.abc import Iterator

from planner.procedure.procedure import Procedure
from planner.procedure.task import Task
from tissue_sim.patient.tube_names import Tube
from tissue_sim.tools.instruments import CLIP_APPLIER, SCISSORS


def _tasks_of(tube: Tube, first_index: int) -> Iterator[Task]:
    steps: list[tuple[str, str, int | None, str]] = []
    for clip, ordinal in enumerate(("first", "second", "third"), start=1):
        steps.append((f"clipping {ordinal} clip", "clip", clip, CLIP_APPLIER))
        steps.append((f"going back {ordinal} clip", "go_back", clip, CLIP_APPLIER))
    steps.append(("go to the cutting position", "cut", None, SCISSORS))
    steps.append(("go back from the cut", "go_back_from_cut", None, SCISSORS))
    for index, (words, kind, clip, tool) in enumerate(steps, start=first_index):
        text = f"{words} {tube} tube"
        yield Task(index=index, text=text, kind=kind, tube=tube, clip=clip, right_tool=tool)


GRAB = Task(index=1, text="grabbing gallbladder", kind="grab", right_tool=CLIP_APPLIER)
TASKS: tuple[Task, ...] = (
    GRAB,
    *_tasks_of("left", first_index=2),
    *_tasks_of("right", first_index=10),
    *_tasks_of("third", first_index=18),
)

CHOLECYSTECTOMY = Procedure(name="cholecystectomy", tasks=TASKS)
"""The procedure of SRT-H, with the third tube, which the learned policies and the language know."""


def duct_first(duct: Tube) -> tuple[Task, ...]:
    """Return the tasks in the order for an artery that crosses the duct: the duct's tube first."""
    return tuple(sorted(TASKS, key=lambda task: (task.is_optional, task.tube not in (None, duct))))


def task_from_text(text: str) -> Task:
    """Return the task with this text.

    Raises:
        ValueError: No task has this text; the message lists the 25 allowed texts.
    """
    return CHOLECYSTECTOMY.named(text)
