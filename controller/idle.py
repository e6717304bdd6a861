"""A controller that does nothing: every evaluation must fail it."""

from __future__ import annotations

from controller.action import Chunk, hold
from planner.instruction import Instruction
from planner.policy_setup import PolicySetup
from tissue_sim.sensing.observation import Observation


class ControllerIdle:
    """Holds both arms where they are."""

    def __init__(self, setup: PolicySetup) -> None:
        del setup

    def reset(self) -> None:
        """Do nothing: there is nothing to forget."""

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Hold both arms, with the jaws as they are."""
        return (hold(observation.joints[:, 6]),)
