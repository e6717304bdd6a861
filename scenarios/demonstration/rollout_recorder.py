"""Record a rollout of a learned controller, labelled with the right instructions.

The scripted planner runs in parallel without control, and the expert advises on the next action.
Both give labels for training a planner: DAgger (Ross et al., arXiv 1011.0686).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from controller.expert.controller import ControllerExpert
from controller.expert.motion import CHUNK_STEPS
from planner.instruction import Instruction
from planner.scripted import PlannerScripted
from scenarios.demonstration.demonstration_recorder import PAUSE_STEPS, DemonstrationRecorder
from scenarios.demonstration.labels import SILENCE, WINDOW_STEPS, Advice, advice_from
from scenarios.loop.step import Step
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation

if TYPE_CHECKING:
    from tissue_sim.world import World


class RolloutRecorder(DemonstrationRecorder):
    """Labels a rollout: the task is the one that the scripted planner would give."""

    def on_reset(self, world: World) -> None:
        """Begin, together with the oracle."""
        super().on_reset(world)
        self._oracle = PlannerScripted(world)
        self._wanted, self._advised = self._oracle.plan(self._exact), SILENCE

    def on_step(self, step: Step) -> None:
        """Add a frame with its labels, and compute the labels of the next."""
        super().on_step(step)
        self._wanted = self._oracle.plan(self._exact)
        self._advised = self._advice() if self._failed else SILENCE

    def _frame(self, step: Step) -> dict[str, Any]:
        frame = super()._frame(step)
        advice = self._advised if frame["failed"] else SILENCE
        return frame | {"task": self._wanted.task.index, "advice": advice, "expert": False}

    def _advice(self) -> Advice:
        """Return the correction that describes the expert's first motion from here."""
        said = Instruction(task=self._wanted.task)
        return advice_from(_coming_seconds(self._world, self._exact, said))

    def _labels(self, frames: Sequence[dict[str, Any]]) -> list[tuple[Advice, bool]]:
        advised = [frame["advice"] for frame in frames]
        return [(advice, advice != SILENCE) for advice in advised]


def _coming_seconds(
    world: World, observation: Observation, said: Instruction
) -> Iterator[tuple[Array, Array]]:
    """Yield motions of tips (2, 3) and jaws (2,) within a second, if the expert acted.

    Later seconds follow, because the expert may pause first; the observation stays the same.
    """
    expert, jaw_rad = ControllerExpert(world), world.target[:, 6]
    tips_m, jaws_rad = [np.zeros((2, 3))], [jaw_rad]
    for ahead_s in np.arange(0, PAUSE_STEPS + WINDOW_STEPS, CHUNK_STEPS) * CONTROL_PERIOD_S:
        chunk = expert.act(replace(observation, time_s=observation.time_s + ahead_s), said)
        tips_m.append(tips_m[-1] + np.sum([a.move_endoscope_m for a in chunk], axis=0))
        jaws_rad.append(chunk[-1].jaw_rad)
    second = WINDOW_STEPS // CHUNK_STEPS
    for before, after in zip(range(len(tips_m)), range(second, len(tips_m)), strict=False):
        yield tips_m[after] - tips_m[before], jaws_rad[after] - jaws_rad[before]
