"""Perturbations that change the world once, some time after the start."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import numpy as np

from planner.task import Task
from scenarios.perturbation.effect import Effect
from scenarios.perturbation.perturbation import AtTime, Onset

if TYPE_CHECKING:
    from tissue_sim.world import World

EARLIEST_S, LATEST_S = 5.0, 60.0  # assumed; a quick procedure is over before the latest


class Once(Effect, ABC):
    """Changes the world once, in one control step."""

    def drawn_onset(self, rng: np.random.Generator) -> Onset:
        return AtTime(time_s=float(rng.uniform(EARLIEST_S, LATEST_S)))

    def before_step(self, world: World, task: Task) -> None:
        if not self.applied and self.due(world, task):
            self.note(world.record.time_s)
            self.change(world)

    @abstractmethod
    def change(self, world: World) -> None:
        """Change the world."""
