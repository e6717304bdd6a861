"""Define a controller that does nothing; every evaluation must fail this controller."""

from __future__ import annotations

from controller.action import Chunk, hold
from planner.instruction import Instruction
from planner.policy_setup import PolicySetup
from tissue_sim.sensing.observation import Observation


class ControllerIdle:
    """Holds both arms at their places."""

    def __init__(self, setup: PolicySetup) -> None:
        del setup

    def reset(self) -> None:
        """Do nothing, because the controller has no memory."""

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Hold both arms, with unchanged jaws."""
        return (hold(observation.joints[:, 6]),)
