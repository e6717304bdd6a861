"""Disturbances that a person can apply by a button."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planner.procedure.task import Task
from scenarios.perturbation.effect import Effect, Once
from scenarios.perturbation.perturbation import AtTime, Perturbation
from tissue_sim.frames import RIGHT, Array

if TYPE_CHECKING:
    from tissue_sim.world import World

NUDGE_S = 1.5  # there and back, assumed

_EFFECTS = "scenarios.perturbation"
MANUAL: dict[str, Perturbation] = {
    p.name: p
    for p in (
        Perturbation(
            name="nudge the tissue",
            description="the body is pushed aside and swings back",
            effect=f"{_EFFECTS}.manual:Nudge",
            magnitude=0.006,
            most=0.02,
            unit="m",
            at=AtTime(time_s=0.0),
        ),
        Perturbation(
            name="drop the clip",
            description="the applier loses its clip",
            effect=f"{_EFFECTS}.manual:Drop",
            magnitude=1.0,
            most=1.0,
            unit="clips",
            at=AtTime(time_s=0.0),
        ),
        Perturbation(
            name="shift the camera",
            description="the endoscope is bumped aside",
            effect=f"{_EFFECTS}.picture:CameraShift",
            magnitude=0.006,
            most=0.02,
            unit="m",
            at=AtTime(time_s=0.0),
        ),
    )
}


class Nudge(Effect):
    """Pushes the body to the right by `magnitude` m and back."""

    def before_step(self, world: World, task: Task) -> None:
        del task
        if not self.applied:
            self._start_s = world.record.time_s
            self.note(self._start_s)

    def offset_m(self, world: World) -> Array | None:
        share = (world.record.time_s + world.config.control_step_s - self._start_s) / NUDGE_S
        if share >= 1.0 + world.config.control_step_s / NUDGE_S:
            return None
        return self.magnitude * np.sin(np.pi * min(share, 1.0)) * RIGHT


class Drop(Once):
    """The applier loses its clip at once, if it holds one."""

    def change(self, world: World) -> None:
        world.drop_clip()
