"""The sense `tracked`: what cameras and encoders might tell, without a picture. It is a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tissue_sim.field import Field
from tissue_sim.sensing.observation import Observation, observation_of
from tissue_sim.sensing.occlusion import Occlusion
from tissue_sim.sensing.sensor_model import SensorModel
from tissue_sim.sensing.tracker import Tracker

USUAL = SensorModel()
LOOK_STEPS = 3  # control steps for which hidden points stay hidden


class SenseTracked:
    """Tells the exact state through a sensor model; what instruments and tissue hide is hidden."""

    def __init__(self, seed: int, model: SensorModel = USUAL) -> None:
        self._tracker = Tracker(model, np.random.default_rng([0x5E45E, seed]))
        self._occluded = Occluded()

    def observe(self, world: Field, exact: Observation) -> Observation:
        """Return what is sensed now; `exact` is the field's exact state now."""
        exact = self._occluded.observe(world, exact)
        sensed = observation_of(self._tracker.track(exact.vector()), exact.time_s)
        return replace(
            sensed,
            T_world_endoscope=exact.T_world_endoscope,
            shaft_offset_m=exact.shaft_offset_m,
        )


class Occluded:
    """Observes the exact state, and which points no camera sees."""

    def __init__(self) -> None:
        self._occlusion, self._n = Occlusion(), 0

    def observe(self, field: Field, exact: Observation) -> Observation:
        """Return the exact observation with its hidden points; call it in each control step."""
        if self._n % LOOK_STEPS == 0:
            self._hidden = self._occlusion.hidden(field, exact)
        self._n += 1
        return replace(exact, hidden=self._hidden)
