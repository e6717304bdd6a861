"""Breathing: the body moves under the instruments while the patient is ventilated."""

from __future__ import annotations

import numpy as np

from planner.task import Task
from scenarios.perturbation.effect import Effect
from scenarios.perturbation.perturbation import AtTime, Onset
from tissue_sim.frames import Array
from tissue_sim.patient.axes import UP
from tissue_sim.world import World

PERIOD_S = 4.0  # 15 breaths a minute under anaesthesia, assumed


class Breathing(Effect):
    """Moves the body by a sine of amplitude `magnitude` m."""

    def drawn_onset(self, rng: np.random.Generator) -> Onset:
        return AtTime(time_s=float(rng.uniform(0.0, PERIOD_S)))

    def before_step(self, world: World, task: Task) -> None:
        if not self.applied and self.due(world, task):
            self._start_s = world.record.time_s
            self.note(self._start_s)

    def offset_m(self, world: World) -> Array | None:
        if not self.applied:
            return None
        time_s = world.record.time_s + world.config.control_step_s - self._start_s
        return self.magnitude * np.sin(2.0 * np.pi * time_s / PERIOD_S) * UP
