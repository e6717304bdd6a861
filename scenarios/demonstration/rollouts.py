"""Watches a learned controller at work and keeps what should have been said to it, step by step.

The scripted planner runs along without a say, and the expert is asked what it would do, as labels
for a planner that learns: DAgger (Ross et al., arXiv 1011.0686).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from controller.action import CONTROL_STEP_S
from controller.expert import ControllerExpert
from controller.expert.motion import CHUNK_STEPS
from controller.expert.skills import JAW_TIME_S
from planner.instruction import Instruction
from planner.scripted import PlannerScripted
from scenarios.demonstration.labels import WINDOW_STEPS, correction_of
from scenarios.demonstration.witness import Witness
from scenarios.episode import Step
from tissue_sim.frames import Array
from tissue_sim.observation import Observation
from tissue_sim.world import World

PAUSE_STEPS = round(JAW_TIME_S / CONTROL_STEP_S)


class WitnessOfRollout(Witness):
    """Labels of a rollout: the task under way is the one that should be."""

    def on_reset(self, world: World) -> None:
        """The oracle begins as well."""
        super().on_reset(world)
        self._oracle = PlannerScripted(world)
        self._wanted = self._oracle.plan(self._seen)

    def on_step(self, step: Step) -> None:
        """What should have been said at the step, and what should be now."""
        super().on_step(step)
        self._wanted = self._oracle.plan(step.observation)

    def _frame(self, step: Step) -> dict[str, Any]:
        frame = super()._frame(step)
        advice = self._advice(step) if frame["failed"] else ""
        return frame | {"task": self._wanted.task.index, "advice": advice, "expert": False}

    def _advice(self, step: Step) -> str:
        """What would have an arm do as the expert would, had it taken over here."""
        said = Instruction(task=self._wanted.task)
        return correction_of(*_next_second(self._world, step.observation, said))

    def _labels(self) -> tuple[list[str], list[bool]]:
        advised = [frame["advice"] for frame in self._frames]
        return advised, [bool(advice) for advice in advised]


def _next_second(world: World, seen: Observation, said: Instruction) -> tuple[Array, Array]:
    """Of tips (2, 3) and jaws (2,) once the expert begins to move, if all else stood still.

    It may pause first: for a second it opens jaws that are open already.
    """
    expert, jaw_rad = ControllerExpert(world), world.target[:, 6]
    moves_m, jaws_rad = list[Array](), [jaw_rad]
    for ahead_s in np.arange(0, PAUSE_STEPS + WINDOW_STEPS, CHUNK_STEPS) * CONTROL_STEP_S:
        chunk = expert.act(replace(seen, time_s=seen.time_s + ahead_s), said)
        moves_m.append(np.sum([action.move_endoscope_m for action in chunk], axis=0))
        jaws_rad.append(chunk[-1].jaw_rad)
    turns_rad = np.diff(jaws_rad, axis=0)
    moving = [m.any() or turn.any() for m, turn in zip(moves_m, turns_rad, strict=True)]
    first = moving.index(True) if any(moving) else 0
    second = slice(first, first + WINDOW_STEPS // CHUNK_STEPS)
    return np.sum(moves_m[second], axis=0), np.sum(turns_rad[second], axis=0)
