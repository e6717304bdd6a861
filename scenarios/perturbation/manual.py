"""Disturbances that a person can apply by a button."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planner.procedure.task import Task
from scenarios.perturbation.effect import Effect, Once
from scenarios.perturbation.perturbation import AtTime, Perturbation, table
from tissue_sim.frames import RIGHT, Array

if TYPE_CHECKING:
    from tissue_sim.world import World

NUDGE_S = 1.5  # there and back, assumed

# fmt: off
MANUAL: dict[str, Perturbation] = {p.name: p for p in table(
    ("nudge the tissue", "manual:Nudge", 0.006, 0.02, "m",
     "the body is pushed aside and swings back"),
    ("drop the clip", "manual:Drop", 1.0, 1.0, "clips", "the applier loses its clip"),
    ("shift the camera", "picture:CameraShift", 0.006, 0.02, "m", "the endoscope is bumped aside"),
    at=AtTime(time_s=0.0),
)}
# fmt: on


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
