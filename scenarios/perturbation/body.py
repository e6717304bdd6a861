"""Effects on the patient's body: unusual stiffness or sizes, breathing, and a push.

A stiffness or a size is moved closer to the limit of the possible values.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from planner.procedure.task import Task
from scenarios.perturbation.effect import Effect
from scenarios.perturbation.perturbation import AtTime, Onset
from tissue_sim.frames import RIGHT, UP, Array
from tissue_sim.patient.anatomy import RANGES, WIDEST_TUBE, Anatomy

if TYPE_CHECKING:
    from tissue_sim.world import World

BREATH_S = 4.0  # 15 breaths a minute under anaesthesia, assumed
NUDGE_S = 1.5  # there and back, assumed


class OutOfRange(Effect):
    """Moves parameters towards the largest possible value by a share, in proportion.

    v -> v (limit / v)^m: m = 0 is the seed's own patient, and m = 1 is the possible limit. Values
    in between are possible, too.
    """

    parameters: ClassVar[tuple[str, ...]] = ()
    limit: ClassVar[str] = "most"

    def on_anatomy(self, anatomy: Anatomy) -> Anatomy:
        self.note(0.0)
        return replace(anatomy, **{name: self._moved(name, anatomy) for name in self.parameters})

    def _possible(self, name: str, anatomy: Anatomy) -> float:
        """Return the largest or smallest possible value of the parameter in this patient."""
        return getattr(RANGES[name], self.limit)

    def _moved(self, name: str, anatomy: Anatomy) -> float:
        value, limit = getattr(anatomy, name), self._possible(name, anatomy)
        moved = value * (limit / value) ** self.magnitude
        low, high = sorted((value, limit))
        return min(max(moved, low), high)  # removes rounding errors


class StiffTissue(OutOfRange):
    parameters = ("stiffness_scale",)


class SoftTissue(OutOfRange):
    parameters = ("stiffness_scale",)
    limit = "least"


class WideTubes(OutOfRange):
    parameters = ("duct_diameter_m", "artery_diameter_m")

    def _possible(self, name: str, anatomy: Anatomy) -> float:
        return min(super()._possible(name, anatomy), WIDEST_TUBE * anatomy.gallbladder_width_m)


class ShortTubes(OutOfRange):
    parameters = ("duct_length_m", "artery_length_m")
    limit = "least"


class LargeGallbladder(OutOfRange):
    parameters = ("gallbladder_length_m", "gallbladder_width_m")


class Breathing(Effect):
    """Moves the ventilated patient's body by a sine of amplitude `magnitude` m."""

    def drawn_onset(self, rng: np.random.Generator) -> Onset:
        return AtTime(time_s=float(rng.uniform(0.0, BREATH_S)))

    def before_step(self, world: World, task: Task) -> None:
        self.begins(world, task)

    def offset_m(self, world: World) -> Array | None:
        if not self.applied:
            return None
        time_s = world.record.time_s + world.config.control_step_s - self.applied[0].time_s
        return self.magnitude * np.sin(2.0 * np.pi * time_s / BREATH_S) * UP


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
