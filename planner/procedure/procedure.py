"""Define a procedure: its tasks in order, and when it may end."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from planner.procedure.task import Task


@dataclass(frozen=True, kw_only=True)
class Procedure:
    """The tasks of an operation, as data.

    Attributes:
        name: Name, as in `calot run --procedure`.
        tasks: The tasks in their usual order; their indices count from 1. A retraction follows each
            clip and cut, and stands right behind it.

    Raises:
        ValueError: The procedure has no task, or optional ones only. Indices do not count from 1,
            or words are not unique. A clip or cut has no retraction behind it, or the last task
            is no retraction. A task is impossible.
    """

    name: str
    tasks: tuple[Task, ...]

    def __post_init__(self) -> None:
        if why := next(self._faults(), None):
            raise ValueError(f"procedure {self.name!r}: {why}")

    def _faults(self) -> Iterator[str]:
        """Yield in words what is wrong with the procedure."""
        if not isinstance(self.tasks, tuple) or not all(isinstance(t, Task) for t in self.tasks):
            yield "its tasks must be a tuple of tasks"
        if [task.index for task in self.tasks] != list(range(1, len(self.tasks) + 1)):
            yield "its tasks' indices must count from 1"
        if not self.tasks or len({task.text for task in self.tasks}) < len(self.tasks):
            yield "it needs tasks, each with its own words"
        for task in self.tasks:
            if why := task.fault:
                yield f"task {task.index}: {why}"
            if task.is_deed and self.retraction_after(task) is None:
                yield f"no retraction after {task.text!r}"
        if all(task.is_optional for task in self.tasks):
            yield "it needs a task for every patient"
        if not self.tasks[-1].goes_back:
            yield "its last task must be a retraction"

    @cached_property
    def _by_text(self) -> dict[str, Task]:
        return {task.text: task for task in self.tasks}

    def holds(self, index: int) -> bool:
        """Return whether the procedure has a task of this index."""
        return 1 <= index <= len(self.tasks)

    def task(self, index: int) -> Task:
        """Return the task of an index.

        Raises:
            ValueError: There is no such task.
        """
        if not self.holds(index):
            raise ValueError(
                f"procedure {self.name!r} has no task {index}; allowed: 1 to {len(self.tasks)}"
            )
        return self.tasks[index - 1]

    def after(self, task: Task) -> Task:
        """Return the next task in the usual order: the retraction after a clip or a cut."""
        return self.task(task.index + 1)

    def retraction_after(self, task: Task) -> Task | None:
        """Return the retraction that stands right behind a task; None if there is none."""
        follower = self.after(task) if self.holds(task.index + 1) else None
        return follower if follower is not None and follower.goes_back else None

    def like(self, task: Task) -> Task | None:
        """Return the task itself, else the first one of its kind, tube and clip; None if none."""
        if task in self.tasks:
            return task
        what = (task.kind, task.tube, task.clip)
        return next((own for own in self.tasks if (own.kind, own.tube, own.clip) == what), None)

    def before(self, task: Task) -> Task:
        """Return the task before in the usual order: the clip or cut of a retraction."""
        return self.task(task.index - 1)

    def tasks_with(self, tubes: Iterable[str]) -> tuple[Task, ...]:
        """Return the tasks of a patient with these tubes: optional tasks need their own tube."""
        there = set(tubes)
        return tuple(task for task in self.tasks if not task.is_optional or task.tube in there)

    def may_end_with(self, task: Task, severed: Mapping[str, bool]) -> bool:
        """Return whether nothing is left after a task.

        A procedure with cuts ends with any retraction, once all its cuts are observed: a person may
        order another last cut. Other procedures end with the last task.

        Args:
            task: The task in force.
            severed: Whether each tube that is there is observed in two parts, by its name.
        """
        tasks = self.tasks_with(severed)
        to_cut = [t.tube for t in tasks if t.severs and t.tube is not None]
        if not to_cut:
            return task == tasks[-1]
        return task.goes_back and all(severed[tube] for tube in to_cut)

    def of(self, deed: str, tube: str, clip: int | None) -> Task:
        """Return the task that clips or cuts a tube; `clip` is the clip's number."""
        return next(t for t in self.tasks if (t.deed, t.tube, t.clip) == (deed, tube, clip))

    def named(self, text: str) -> Task:
        """Return the task with these words.

        Raises:
            ValueError: No task has these words; the message lists the allowed words.
        """
        try:
            return self._by_text[text]
        except KeyError:
            raise ValueError(
                f"unknown task {text!r}; allowed: {', '.join(self._by_text)}"
            ) from None
