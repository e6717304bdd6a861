"""Effects on the robot's signals: late actions, and errors of the sense `tracked`."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from controller.action import ToolAction, hold
from planner.procedure.task import Task
from scenarios.perturbation.effect import Effect
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.sensing.sensor_model import SensorModel

if TYPE_CHECKING:
    from tissue_sim.world import World

SIZES = {  # of a perturbation: the size in the sensor model that its magnitude replaces
    "point-jitter": "white_m",
    "point-bias": "scene_m",
    "point-dropout": "dropout",
    "sensing-delay": "delay_s",
    "hand-eye": "hand_eye_m",
}


class Latency(Effect):
    """Delays each action by `magnitude` control steps; the robot holds while none arrives.

    Actions that arrive during a tool exchange are lost.
    """

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        super().__init__(perturbation, rng)
        self._sent: deque[tuple[int, ToolAction]] = deque()

    def on_action(self, action: ToolAction, world: World, task: Task) -> ToolAction:
        self.begins(world, task)
        now = round(world.record.time_s / CONTROL_PERIOD_S)
        if not self.applied:
            return action
        self._sent.append((now, action))
        while self._sent[0][0] < now - self.magnitude:
            self._sent.popleft()
        sent, oldest = self._sent[0]
        return oldest if sent == now - self.magnitude else hold(world.target[:, 6])


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
        self.begins(world, task)
