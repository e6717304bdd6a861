"""Watches a learned controller at work and keeps what should have been said to it, step by step.

The scripted planner and the expert run along without a say, as labels for a planner that learns:
DAgger (Ross et al., arXiv 1011.0686).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from controller.action import CONTROL_STEP_S, Chunk
from controller.expert import ControllerExpert
from planner.instruction import Instruction
from planner.scripted import PlannerScripted
from scenarios.demonstration.labels import correction_of
from scenarios.demonstration.witness import Witness
from scenarios.episode import Step
from tissue_sim.frames import Array
from tissue_sim.world import World


class WitnessOfRollout(Witness):
    """Labels of a rollout: the task under way is the one that should be."""

    def on_reset(self, world: World) -> None:
        """Oracle and expert begin as well."""
        super().on_reset(world)
        self._oracle, self._expert = PlannerScripted(world), ControllerExpert(world)
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
        self._expert.reset()
        said = Instruction(task=self._wanted.task)
        return correction_of(*_motion_in_a_second(self._expert.act(step.observation, said)))

    def _labels(self) -> tuple[list[str], list[bool]]:
        advised = [frame["advice"] for frame in self._frames]
        return advised, [bool(advice) for advice in advised]


def _motion_in_a_second(chunk: Chunk) -> tuple[Array, Array]:
    """Of tips (2, 3) and jaws (2,), if it goes on as it begins."""
    moved_m = np.mean([action.move_endoscope_m for action in chunk], axis=0) / CONTROL_STEP_S
    jaws_rad = np.stack([action.jaw_rad for action in chunk])
    return moved_m, np.diff(jaws_rad, axis=0).mean(axis=0) / CONTROL_STEP_S
