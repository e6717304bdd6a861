"""The senses `cameras` and `endoscope`: from pictures, encoders and motor currents to points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from controller.perception.perception import Perception
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.pictures.cameras import CameraSpec
from tissue_sim.sensing.pictures.eyes import USUAL, VIEWS, Eyes, Spoil, as_it_is
from tissue_sim.sensing.sensor_model import SensorModel
from tissue_sim.world import World


class SenseCameras:
    """Perceives one patient; the world must have been made with `render`."""

    def __init__(
        self,
        seed: int,
        perception: Perception,
        model: SensorModel = USUAL,
        spoil: Spoil = as_it_is,
        views: Sequence[CameraSpec] = VIEWS,
    ) -> None:
        """Perceive in `views` with the errors of this seed; pictures pass through `spoil`."""
        rng = np.random.default_rng([0x5EE, seed])
        self._eyes = Eyes(rng, model, spoil=spoil, views=views)
        self._perception = perception

    def observe(self, world: World, exact: Observation) -> Observation:
        """Return what is perceived now; of the exact state, encoders and currents tell a part.

        Raises:
            ValueError: the world has no cameras.
        """
        if world.view is None:
            raise ValueError("sense cameras: the world has none: make it with render=True")
        glance = self._eyes.glance(world, world.view, exact, self._perception.aim_m)
        return self._perception.estimate(glance)
