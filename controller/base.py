"""What every controller can do."""

from __future__ import annotations

from typing import Protocol

from controller.action import Chunk
from planner.instruction import Instruction
from tissue_sim.sensing.observation import Observation


class Controller(Protocol):
    """Turns an instruction and what is seen into the next motions."""

    def reset(self) -> None:
        """Forget what was under way: an episode starts, or the tool was exchanged."""
        ...

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """The next motions, at least one; a new instruction may cut them short."""
        ...
