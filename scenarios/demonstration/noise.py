"""Noise in the expert's motion, so that the data shows how the expert returns to its path.

After Laskey et al., "DART: noise injection for robust imitation learning", 2017. Here the noise
comes in bursts with pauses: an imitated action chunk must not react to noise that its observation
could not show yet.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from controller.action import ToolAction
from controller.expert.motion import progress
from planner.procedure.task import Task
from scenarios.perturbation.effect import Effect
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array, exponential, rotation_from_6d, rotation_to_6d, unit
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

if TYPE_CHECKING:
    from tissue_sim.world import World

# Assumed, all of them; Laskey et al. fit their noise to a learner's errors.
QUIET_S = (1.5, 4.0)  # between two bursts
BURST_S = (0.3, 0.6)
CLOSE_M = 0.004  # no noise nearer to tissue than this
SHARE_OF_DISTANCE = 0.25  # largest offset, relative to the remaining distance to tissue
MAX_M, MAX_RAD = 0.005, 0.15

NOISE = Perturbation(
    name="noise",
    description="the expert's arms are pushed about a little",
    effect="scenarios.demonstration.noise:NoiseBursts",
    magnitude=1.0,
    most=2.0,
    unit="of the usual strength",
)


class NoiseBursts(Effect):
    """Moves an arm smoothly by some mm at random times, less near tissue."""

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        super().__init__(perturbation, rng)
        self._rng = rng
        self._rest()

    def on_action(self, action: ToolAction, world: World, task: Task) -> ToolAction:
        del task
        self._quiet_steps -= 1
        if self._quiet_steps > 0:
            return action
        if self._quiet_steps == 0:
            self._start(world)
        share, self._shares = self._shares[0], self._shares[1:]
        if not len(self._shares):
            self._rest()
        moved, turned = share * self._offset_m, exponential(share * self._turn_rad)
        return self._added(action, moved, turned) if self._offset_m.any() else action

    def _rest(self) -> None:
        self._quiet_steps = _steps(self._rng.uniform(*QUIET_S))

    def _start(self, world: World) -> None:
        rng = self._rng
        room = [_room(world, arm) for arm in (LEFT_ARM, RIGHT_ARM)]
        self._arm = int(
            rng.uniform() * sum(room) >= room[LEFT_ARM]
        )  # more often the one farther from tissue
        n = _steps(rng.uniform(*BURST_S))
        self._shares: Array = np.diff(progress(np.linspace(0.0, 1.0, n + 1)))
        strength = self.magnitude * room[self._arm] * rng.uniform(0.3, 1.0)
        self._offset_m: Array = strength * MAX_M * unit(rng.normal(size=3))
        self._turn_rad: Array = strength * MAX_RAD * unit(rng.normal(size=3))

    def _added(self, action: ToolAction, moved_m: Array, turned: Array) -> ToolAction:
        moves, turns = action.move_endoscope_m.copy(), action.turn_tool.copy()
        moves[self._arm] += moved_m
        turns[self._arm] = rotation_to_6d(rotation_from_6d(turns[self._arm]) @ turned)
        return replace(action, move_endoscope_m=moves, turn_tool=turns)


def _room(world: World, arm: int) -> float:
    """Return the allowed strength: 0 close to tissue, 1 well away from it."""
    tip = world.arms.T_world_tool()[arm, :3, 3]
    off_m = float(np.linalg.norm(world.tissue.positions() - tip, axis=1).min())
    return float(np.clip(SHARE_OF_DISTANCE * (off_m - CLOSE_M) / MAX_M, 0.0, 1.0))


def _steps(time_s: float) -> int:
    return round(time_s / CONTROL_PERIOD_S)
