"""The sense `tracked`: what cameras and encoders might tell, without a picture. It is a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tissue_sim.field import Field
from tissue_sim.sensing.exact import exact_observation
from tissue_sim.sensing.observation import POINTS, Observation, fields
from tissue_sim.sensing.occlusion import Occlusion
from tissue_sim.sensing.sensor_model import SensorModel
from tissue_sim.sensing.tracker import Tracker

LOOK_STEPS = 3  # control steps for which hidden points stay hidden


class SenseTracked:
    """Tells the exact state through a sensor model; what instruments and tissue hide is hidden."""

    def __init__(self, seed: int, model: SensorModel | None = None) -> None:
        self._tracker = Tracker(model or SensorModel(), np.random.default_rng([0x5E45E, seed]))
        self._occluded = Occluded()

    def observe(self, world: Field) -> Observation:
        """Return what is sensed now."""
        exact = self._occluded.observe(world)
        return told(exact, self._tracker.see(exact.vector()))


class Occluded:
    """Observes the exact state, and which points no camera sees."""

    def __init__(self) -> None:
        self._occlusion, self._n = Occlusion(), 0

    def observe(self, field: Field) -> Observation:
        """Return the exact observation with its hidden points; call it in each control step."""
        exact = exact_observation(field)
        if self._n % LOOK_STEPS == 0:
            self._hidden = self._occlusion.hidden(field, exact)
        self._n += 1
        return replace(exact, hidden=self._hidden)


def told(exact: Observation, sensed: np.ndarray) -> Observation:
    """Return an observation with what is sensed: an `Observation.vector()`."""
    parts = {name: part.astype(float) for name, part in fields(sensed).items()}
    tips = exact.tips_endoscope.copy()
    tips[:, :3] = parts["tips_endoscope"]
    return replace(
        exact,
        joints=parts["joints"],
        tips_endoscope=tips,
        forces_n=parts["forces_n"],
        pinch_n=float(parts["pinch_n"][0]),
        **{name: parts[name] for name in POINTS},
        severed=parts["severed"] > 0.5,
        tube_radius_m=parts["tube_radius_m"],
        third_tube=float(parts["third_tube"][0]),
        std_m=parts["std_m"],
        age_s=parts["age_s"],
        hidden=parts["hidden"] > 0.5,
    )
