"""Errors of the sense `tracked`, stronger than usual."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planner.task import Task
from scenarios.perturbation.effect import Effect
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.sensing.sensor_model import SensorModel
from tissue_sim.world import World

SIZES = {  # of a perturbation: the size in the sensor model that its magnitude replaces
    "point-jitter": "white_m",
    "point-bias": "scene_m",
    "point-dropout": "dropout",
    "sensing-delay": "delay_s",
    "hand-eye": "hand_eye_m",
}


class SensorError(Effect):
    """Replaces one size of the sensor model by the magnitude, unless the usual one is larger."""

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        super().__init__(perturbation, rng)
        self._size = SIZES[perturbation.name]

    def on_senses(self, model: SensorModel) -> SensorModel:
        """Return the sensor model with the larger error."""
        usual = getattr(model, self._size)
        return replace(model, **{self._size: max(usual, self.magnitude)})

    def before_step(self, world: World, task: Task) -> None:
        """Note the onset: the error lasts for the whole episode."""
        if not self.applied and self.due(world, task):
            self.note(world.record.time_s)
