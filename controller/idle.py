"""A controller that does nothing: what an evaluation must not pass."""

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
        """Nothing to forget."""

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Hold, jaws as they are."""
        return (hold(observation.joints[:, 6]),)
