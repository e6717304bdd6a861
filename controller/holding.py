"""Rest both arms: in a hold unless a person corrects one, or as a controller that does nothing."""

from __future__ import annotations

import numpy as np

from controller.action import Chunk, ToolAction, hold
from controller.correction import carried_out, moved_by_person
from planner.instruction import Instruction
from planner.policy_setup import PolicySetup
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import HELD_PINCH_N


class Holding:
    """Keeps jaws at their angles as a hold begins.

    Jaws lag behind their command, so a closing jaw would continue to close. A grasper that holds
    tissue keeps its command, which is its grip.
    """

    def __init__(self) -> None:
        self._jaw_rad: Array | None = None  # since a hold began

    def end(self) -> None:
        """Register that the arms do not hold."""
        self._jaw_rad = None

    def action(
        self,
        instruction: Instruction,
        observation: Observation,
        commanded: Array,
        led: int | None = None,
    ) -> ToolAction:
        """Return the action of a step in a hold.

        Args:
            instruction: The instruction in force.
            observation: The present observation.
            commanded: (2,) the jaws' last command.
            led: The arm that a person leads by the hand; None for none.
        """
        grips = np.array([observation.pinch_n >= HELD_PINCH_N, False])
        now_rad = np.where(grips, commanded, np.maximum(commanded, observation.joints[:, 6]))
        if self._jaw_rad is None:
            self._jaw_rad = now_rad
        self._jaw_rad = np.where(moved_by_person(instruction, led), now_rad, self._jaw_rad)
        return carried_out(hold(self._jaw_rad), instruction, commanded)


class ControllerIdle:
    """Holds both arms at their places; every evaluation must fail this controller."""

    def __init__(self, setup: PolicySetup) -> None:
        del setup

    def reset(self) -> None:
        """Do nothing, because the controller has no memory."""

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Hold both arms, with unchanged jaws."""
        return (hold(observation.joints[:, 6]),)
