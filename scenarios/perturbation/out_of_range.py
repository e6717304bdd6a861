"""Patients beyond those of the training seeds: stiffness and sizes towards the possible limit."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

from scenarios.perturbation.effect import Effect
from tissue_sim.anatomy import RANGES, Anatomy


class OutOfRange(Effect):
    """Moves parameters a share of the way, in proportion, to the largest possible value.

    v -> v (limit / v)^m: at m = 0 the seed's own patient, at m = 1 the limit of what is possible,
    legal in between.
    """

    parameters: ClassVar[tuple[str, ...]] = ()
    limit: ClassVar[str] = "most"

    def on_anatomy(self, anatomy: Anatomy) -> Anatomy:
        self.note(0.0)
        return replace(
            anatomy,
            **{name: self._moved(name, getattr(anatomy, name)) for name in self.parameters},
        )

    def _moved(self, name: str, value: float) -> float:
        possible = RANGES[name]
        moved = value * (getattr(possible, self.limit) / value) ** self.magnitude
        return min(max(moved, possible.least), possible.most)  # but for rounding it is there


class StiffTissue(OutOfRange):
    parameters = ("stiffness_scale",)


class SoftTissue(OutOfRange):
    parameters = ("stiffness_scale",)
    limit = "least"


class WideTubes(OutOfRange):
    parameters = ("duct_diameter_m", "artery_diameter_m")


class ShortTubes(OutOfRange):
    parameters = ("duct_length_m", "artery_length_m")
    limit = "least"


class LargeGallbladder(OutOfRange):
    parameters = ("gallbladder_length_m", "gallbladder_width_m")
