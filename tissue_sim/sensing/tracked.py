"""Implement the sense `tracked`, a model of cameras and encoders without a picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tissue_sim.field import Field
from tissue_sim.sensing.observation import Observation, observation_of
from tissue_sim.sensing.occlusion import Occlusion
from tissue_sim.sensing.sensor_model import SenseSetup, SensorModel
from tissue_sim.sensing.tracker import Tracker

USUAL = SensorModel()
LOOK_STEPS = 3  # control steps for which hidden points stay hidden


class SenseTracked:
    """Passes the exact state through a sensor model; instruments and tissue hide points."""

    def __init__(self, seed: int, model: SensorModel = USUAL) -> None:
        self._tracker = Tracker(model, np.random.default_rng([0x5E45E, seed]))
        self._occluded = Occluded()

    def observe(self, world: Field, exact: Observation) -> Observation:
        """Return the current sensor values; `exact` is the field's current exact state."""
        exact = self._occluded.observe(world, exact)
        return observation_of(
            self._tracker.track(exact.vector()),
            exact.time_s,
            T_world_endoscope=exact.T_world_endoscope,
            shaft_offset_m=exact.shaft_offset_m,
        )


def make(setup: SenseSetup) -> SenseTracked:
    """Return the sense of an episode."""
    return SenseTracked(setup.seed, setup.model)


class Occluded:
    """Returns the exact state with the points that no camera observes."""

    def __init__(self) -> None:
        self._occlusion, self._n = Occlusion(), 0

    def observe(self, field: Field, exact: Observation) -> Observation:
        """Return the exact observation with its hidden points; call it in each control step."""
        if self._n % LOOK_STEPS == 0:
            self._hidden = self._occlusion.hidden(field, exact)
        self._n += 1
        return replace(exact, hidden=self._hidden)
