"""The interface of every controller."""

from __future__ import annotations

from typing import Protocol

from controller.action import Chunk
from planner.instruction import Instruction
from tissue_sim.sensing.observation import Observation


class Controller(Protocol):
    """Turns an instruction and an observation into the next motions."""

    def reset(self) -> None:
        """Forget the current motion: an episode starts, or a tool was exchanged."""
        ...

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Return the next motions, at least one; a new instruction may cut them short."""
        ...
