"""Estimate the right tool's place relative to the observation, from a person's corrections.

Suppose a person moves the right arm and then has its jaws closed. Then the task's place is between
the jaws, whatever the observation says. The offset from the jaws to the observed place counts as an
error of the arm's registration (hand-eye calibration), which lasts.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planner.correction import DIRECTION_ENDOSCOPE
from planner.instruction import Instruction
from planner.procedure.task import Task
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import RIGHT_ARM

WORTH_TELLING_M = 5e-4  # along an axis: an offset that a person can see; assumed
MOST_M = 0.010  # by which a registration can be wrong; assumed

_WORDS = {
    "left": "farther left", "right": "farther right", "higher": "higher", "lower": "lower",
    "away": "farther away", "towards": "nearer to you",
}  # fmt: skip


class ToolPlace:
    """Follows a person's corrections.

    Attributes:
        offset_m: (3,) offset of the right tool from its arm's registration, endoscope frame.
    """

    def __init__(self) -> None:
        self.offset_m: Array = np.zeros(3)
        self._moved_in: Task | None = None

    def corrected(self, observation: Observation) -> Observation:
        """Return an observation with the right tip at its corrected place."""
        if not self.offset_m.any():
            return observation
        tips = observation.tips_endoscope.copy()
        tips[RIGHT_ARM, :3, 3] += self.offset_m
        return replace(observation, tips_endoscope=tips)

    @property
    def in_words(self) -> str:
        """Return the tool's offset in words, for the person who corrected it."""
        ways = [
            f"{1e3 * way_m:.1f} mm {_WORDS[name]}"
            for name, way in DIRECTION_ENDOSCOPE.items()
            if (way_m := float(self.offset_m @ way)) >= WORTH_TELLING_M
        ]
        place = ", ".join(ways) or "where the arm's encoders have it"
        return f"I take the right tool to be {place} from now on."

    def follow(self, observation: Observation, instruction: Instruction) -> bool:
        """Take in one control step; return whether the tool's offset has changed.

        Args:
            observation: The observation, as corrected so far.
            instruction: The instruction in force.
        """
        said, task = instruction.correction, instruction.task
        if self._moved_in != task:
            self._moved_in = None
        if said is None or said.arm == "left" or instruction.source != "human":
            return False
        if said.direction is not None:
            self._moved_in = task
        if said.jaw != "close" or self._moved_in is None:
            return False
        self._moved_in = None
        return self._learn(observation, task)

    def _learn(self, observation: Observation, task: Task) -> bool:
        from controller.diffusion.scene.scene import Scene  # heavy to import, and seldom needed
        from controller.diffusion.scene.task_place import task_place

        place = task_place(Scene(observation.vector()), task)
        if place is None or np.linalg.norm(self.offset_m + place.off_m) > MOST_M:
            return False
        self.offset_m = self.offset_m + place.off_m
        return True
