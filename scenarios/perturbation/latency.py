"""Actions reach the robot late."""

from __future__ import annotations

from collections import deque

import numpy as np

from controller.action import ToolAction, hold
from planner.task import Task
from scenarios.perturbation.effect import Effect
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.periods import CONTROL_PERIOD_S
from tissue_sim.world import World


class Latency(Effect):
    """Delays each action by `magnitude` control steps; the robot holds while none arrives.

    Actions that arrive during a tool exchange are lost.
    """

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        super().__init__(perturbation, rng)
        self._sent: deque[tuple[int, ToolAction]] = deque()

    def before_step(self, world: World, task: Task) -> None:
        if not self.applied and self.due(world, task):
            self.note(world.record.time_s)

    def on_action(self, action: ToolAction, world: World) -> ToolAction:
        now = round(world.record.time_s / CONTROL_PERIOD_S)
        if not self.applied:
            return action
        self._sent.append((now, action))
        while self._sent[0][0] < now - self.magnitude:
            self._sent.popleft()
        sent, oldest = self._sent[0]
        return oldest if sent == now - self.magnitude else hold(world.target[:, 6])
