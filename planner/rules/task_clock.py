"""Measure how long a task has lasted, and the grasper has done its part, by observation."""

from __future__ import annotations

from planner.base import PLANNING_PERIOD_S
from planner.scene.predicates import has_slipped, is_grasped, pulls
from tissue_sim.sensing.observation import Observation


class TaskClock:
    """Counts time while a planner is asked; tool exchanges, without requests, do not count.

    Attributes:
        since_s: Time since the task in force was given.
        pulled_s: Time for which the grasper has held and pulled without a break.
        grasped_s: Time for which the grasp has surely been good without a break.
        slipped_s: Time for which the grasper has held nothing without a break, before the first
            cut.
    """

    def __init__(self) -> None:
        self.since_s = self.pulled_s = self.grasped_s = self.slipped_s = 0.0
        self._now_s: float | None = None

    def update(self, seen: Observation) -> None:
        """Take in one observation."""
        if self._now_s is not None:
            passed_s = min(seen.time_s - self._now_s, PLANNING_PERIOD_S)
            self.since_s += passed_s
            self.pulled_s = self.pulled_s + passed_s if pulls(seen) else 0.0
            self.grasped_s = self.grasped_s + passed_s if is_grasped(seen) else 0.0
            self.slipped_s = self.slipped_s + passed_s if has_slipped(seen) else 0.0
        self._now_s = seen.time_s

    def begin(self) -> None:
        """Begin another task."""
        self.since_s = 0.0
