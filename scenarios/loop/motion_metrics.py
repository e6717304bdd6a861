"""Measure the motion of the arms, and the planner's chance of failure in each task."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from scenarios.loop.results import TaskResult

if TYPE_CHECKING:  # both are heavy to import
    from scenarios.loop.step import Step
    from tissue_sim.world import World


class MotionMetrics:
    """Measures an episode's steps, except tool exchanges, which the nurse commands."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._stretches: dict[int, list[list[NDArray]]] = {}
        self._going_on: int | None = None  # the task whose stretch is open
        self._chance: dict[int, float] = {}
        self._alarm_s: dict[int, float] = {}

    def on_step(self, step: Step) -> None:
        """Keep the tips' positions and the planner's assessment."""
        task = step.instruction.task.index
        if step.exchange:
            self._going_on = None
            return
        if task != self._going_on:
            self._stretches.setdefault(task, []).append([])
            self._going_on = task
        self._stretches[task][-1].append(step.exact.tips_endoscope[:, :, 3])
        if (seen := step.instruction.assessment) is not None:
            self._chance[task] = max(self._chance.get(task, 0.0), seen.failure_chance)
            if seen.alarm:
                self._alarm_s.setdefault(task, step.time_s)

    def measured(self, tasks: Sequence[TaskResult]) -> tuple[TaskResult, ...]:
        """Return the tasks' results with the measurements."""
        return tuple(self._measured(task) for task in tasks)

    def _measured(self, task: TaskResult) -> TaskResult:
        stretches = [np.stack(tips)[..., :3] for tips in self._stretches.get(task.index, ())]
        dt_s = self._world.config.control_step_s
        return replace(
            task,
            path_m=_pair(sum((path_m(tips) for tips in stretches), np.zeros(2))),
            jerk_m_s3=mean_jerk_m_s3(stretches, dt_s),
            failure_chance=self._chance.get(task.index),
            alarm_s=self._alarm_s.get(task.index),
        )


def path_m(tips: NDArray) -> NDArray:
    """Return (2,) path lengths of both tips through positions (n, 2, 3)."""
    return np.linalg.norm(np.diff(tips, axis=0), axis=-1).sum(axis=0)


def mean_jerk_m_s3(stretches: Sequence[NDArray], dt_s: float) -> tuple[float, float] | None:
    """Return the mean size of the third difference quotient of positions (n, 2, 3) `dt_s` apart.

    The mean is over all stretches of motion; None if no stretch has four positions.
    """
    jerks = [np.linalg.norm(np.diff(tips, n=3, axis=0), axis=-1) for tips in stretches]
    together = np.concatenate([np.empty((0, 2)), *jerks])
    return _pair(together.mean(axis=0) / dt_s**3) if len(together) else None


def _pair(values: NDArray) -> tuple[float, float]:
    left, right = values.tolist()
    return left, right
