"""Record an episode's tasks: their success, their duration, and their corrections."""

from __future__ import annotations

from typing import TYPE_CHECKING

from planner.instruction import Instruction, Source
from planner.procedure.outcomes import is_needed, task_done
from planner.procedure.procedure import Procedure
from planner.procedure.task import Task
from scenarios.loop.results import TaskResult
from scenarios.loop.step import Step

if TYPE_CHECKING:
    from tissue_sim.world import World


class TaskRecord:
    """Assigns each step to the instructed task, and records the tasks that have succeeded.

    Attributes:
        results: Result of each task begun so far, by index.
    """

    def __init__(self, world: World, procedure: Procedure) -> None:
        self.results: dict[int, TaskResult] = {}
        self._world, self._procedure = world, procedure
        self._control_step_s = world.config.control_step_s
        self._correction: tuple[str, Source, float] | None = None  # in force at the last step
        self._n_clips = -1  # when `_needed` was found: the first clip of a tube shows its kind
        self._needed: tuple[Task, ...] = ()

    def note(self, step: Step, planned: Task) -> None:
        """Record one step; `planned` is the planner's current task.

        A task that has succeeded keeps that result unless it is instructed again. A task that was
        left undone or skipped may succeed while another one is instructed.
        """
        self._credit(
            step.instruction.task,
            success=step.outcome.task_done,
            time_s=0.0 if step.held else self._control_step_s,
            corrections=int(self._begins_correction(step.instruction)),
        )
        task_of = self._procedure.task
        done = {task_of(k) for k, task in self.results.items() if task.success}
        self._find_needed()
        before = {task for task in self._needed if task.index <= planned.index}
        due = before | {task_of(k) for k in self.results}
        for task in (due - done) | {planned}:
            if task != step.instruction.task and task_done(task, self._world):
                self._credit(task, success=True)

    @property
    def is_complete(self) -> bool:
        """Return whether all tasks that this patient needs have succeeded, in any order."""
        self._find_needed()
        done = {k for k, task in self.results.items() if task.success}
        return done.issuperset(task.index for task in self._needed)

    def in_order(self) -> tuple[TaskResult, ...]:
        """Return the results by index, including tasks that the rule for fewer clips left out."""
        self._find_needed()
        left_out = {
            task.index: TaskResult(
                index=task.index,
                instruction=task.text,
                success=False,
                time_s=0.0,
                corrections=0,
                left_out=True,
            )
            for task in self._procedure.tasks[: max(self.results, default=0)]
            if task not in self._needed
        }
        return tuple(dict(sorted({**left_out, **self.results}.items())).values())

    def _find_needed(self) -> None:
        """Find the tasks that this patient needs, by the clips on the tubes so far."""
        n_clips = len(self._world.record.clips)
        if n_clips != self._n_clips:
            tasks = self._procedure.tasks
            self._needed = tuple(task for task in tasks if is_needed(task, self._world))
            self._n_clips = n_clips

    def _credit(
        self, task: Task, *, success: bool, time_s: float = 0.0, corrections: int = 0
    ) -> None:
        before = self.results.get(task.index)
        self.results[task.index] = TaskResult(
            index=task.index,
            instruction=task.text,
            success=success,
            time_s=(before.time_s if before else 0.0) + time_s,
            corrections=(before.corrections if before else 0) + corrections,
        )

    def _begins_correction(self, instruction: Instruction) -> bool:
        """Return whether a correction is in force that was not in force at the step before."""
        before, self._correction = self._correction, _correction_in(instruction)
        return self._correction not in (None, before)


def _correction_in(instruction: Instruction) -> tuple[str, Source, float] | None:
    """Return the identity of the correction in force.

    A planner repeats its correction while the correction lasts; the time identifies a person's.
    """
    if instruction.correction is None:
        return None
    given_s = instruction.time_s if instruction.source == "human" else 0.0
    return instruction.text, instruction.source, given_s
