"""The endoscope is bumped: its position or its direction changes.

The robot knows the endoscope's pose (its holder has encoders). Actions therefore keep their
meaning: they are in the current endoscope frame. The picture and every position in that frame
change.
"""

from __future__ import annotations

import numpy as np

from scenarios.perturbation.once import Once
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.frames import exponential, pose, unit
from tissue_sim.world import World


class CameraShift(Once):
    """Shifts the endoscope by `magnitude` m in a random direction."""

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        super().__init__(perturbation, rng)
        self._change = self.magnitude * unit(rng.normal(size=3))

    def change(self, world: World) -> None:
        world.T_world_endoscope = world.T_world_endoscope @ pose(np.eye(3), self._change)


class CameraTurn(CameraShift):
    """Turns the endoscope by `magnitude` rad about a random axis through its tip."""

    def change(self, world: World) -> None:
        turned = pose(exponential(self._change), np.zeros(3))
        world.T_world_endoscope = world.T_world_endoscope @ turned
