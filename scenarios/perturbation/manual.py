"""The effects of disturbances that a person can apply by a button (`perturbations.MANUAL`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planner.procedure.task import Task
from scenarios.perturbation.effect import Effect, Once
from tissue_sim.frames import RIGHT, Array

if TYPE_CHECKING:
    from tissue_sim.world import World

NUDGE_S = 1.5  # there and back, assumed


class Nudge(Effect):
    """Pushes the body to the right by `magnitude` m and back."""

    def before_step(self, world: World, task: Task) -> None:
        del task
        if not self.applied:
            self.note(world.record.time_s)

    def offset_m(self, world: World) -> Array | None:
        step_s = world.config.control_step_s
        share = (world.record.time_s + step_s - self.applied[0].time_s) / NUDGE_S
        if share >= 1.0 + step_s / NUDGE_S:
            return None
        return self.magnitude * np.sin(np.pi * min(share, 1.0)) * RIGHT


class Drop(Once):
    """The applier loses its clip at once, if it holds one."""

    def change(self, world: World) -> None:
        world.drop_clip()
