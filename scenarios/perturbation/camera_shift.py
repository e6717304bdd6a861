"""The endoscope is bumped: it looks from elsewhere, or elsewhere, from then on.

The robot knows where its endoscope is (its holder has encoders), so actions keep their meaning:
they are in the frame that is seen. What changes is the picture and every position in it.
"""

from __future__ import annotations

import numpy as np

from scenarios.perturbation.once import Once
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.frames import exponential, pose, unit
from tissue_sim.world import World


class CameraShift(Once):
    """Shifts the endoscope by `magnitude` m, any way."""

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        super().__init__(perturbation, rng)
        self._change = self.magnitude * unit(rng.normal(size=3))

    def change(self, world: World) -> None:
        world.T_world_endoscope = world.T_world_endoscope @ pose(np.eye(3), self._change)


class CameraTurn(CameraShift):
    """Turns the endoscope by `magnitude` rad about any axis through its tip."""

    def change(self, world: World) -> None:
        turned = pose(exponential(self._change), np.zeros(3))
        world.T_world_endoscope = world.T_world_endoscope @ turned
