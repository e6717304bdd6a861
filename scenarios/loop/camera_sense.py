"""The senses `cameras` and `endoscope`: points from pictures, encoders and currents."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from controller.perception.perception import Perception, load_perception
from tissue_sim.sensing.cameras import CameraSpec
from tissue_sim.sensing.eyes import (
    ENDOSCOPE_VIEWS,
    USUAL,
    VIEWS,
    Eyes,
    as_it_is,
)
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.sensor_model import PictureFault, SenseSetup, SensorModel

if TYPE_CHECKING:
    from tissue_sim.world import World


class SenseCameras:
    """Perceives one patient; the world must have been made with `render`."""

    def __init__(
        self,
        seed: int,
        perception: Perception,
        model: SensorModel = USUAL,
        picture_fault: PictureFault = as_it_is,
        views: Sequence[CameraSpec] = VIEWS,
    ) -> None:
        """Perceive in `views` with the errors of this seed; `picture_fault` alters pictures."""
        rng = np.random.default_rng([0x5EE, seed])
        self._eyes = Eyes(rng, model, picture_fault=picture_fault, views=views)
        self._perception = perception

    def observe(self, world: World, exact: Observation) -> Observation:
        """Return the estimate; encoders and motor currents are read from the exact state.

        Raises:
            ValueError: The world has no cameras.
        """
        if world.view is None:
            raise ValueError("sense cameras: the world has none: make it with render=True")
        glance = self._eyes.glance(world, world.view, exact, self._perception.aim_m)
        return self._perception.estimate(glance)


def make(setup: SenseSetup) -> SenseCameras:
    """Return the sense of an episode, by the endoscope and both wrist cameras.

    Raises:
        CheckpointError: The file holds no perception, or the perception does not fit.
    """
    return _made(setup, VIEWS)


def make_endoscope(setup: SenseSetup) -> SenseCameras:
    """Return the sense of an episode, by the endoscope alone.

    Raises:
        CheckpointError: The file holds no perception, or the perception does not fit.
    """
    return _made(setup, ENDOSCOPE_VIEWS)


def _made(setup: SenseSetup, views: Sequence[CameraSpec]) -> SenseCameras:
    perception = load_perception(setup.checkpoint)
    return SenseCameras(
        setup.seed, perception, picture_fault=setup.picture_fault or as_it_is, views=views
    )
