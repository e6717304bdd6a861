"""Define the interface of every controller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from controller.action import Chunk, ToolAction
from planner.instruction import Instruction
from tissue_sim.sensing.observation import Observation


class Controller(Protocol):
    """Turns an instruction and an observation into the next motions.

    A controller that has learned corrections may have a true attribute `obeys_corrections`. Then it
    carries out a person's corrections of an arm itself, while a guard watches
    (`controller.correction`).
    """

    def reset(self) -> None:
        """Forget the current motion: an episode starts, or others have moved the arms.

        The loop calls `reset`:

        - as an episode starts,
        - after each tool exchange,
        - in each control step in which a person holds the arms or a perturbation leads one,
        - where the right tool's place was learned anew.
        """
        ...

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Return the next motions, at least one; a new instruction may cut them short."""
        ...


def obeys_corrections(controller: object) -> bool:
    """Return whether a controller carries out corrections of an arm itself."""
    return bool(getattr(controller, "obeys_corrections", False))


def require_chunk(chunk: object) -> Chunk:
    """Return the output of a controller's `act`, after a check.

    Raises:
        TypeError: The chunk is no sequence of motions.
        ValueError: The chunk has no motion.
    """
    if not isinstance(chunk, Sequence):
        raise TypeError(f"controller: act returned a {_kind(chunk)}, not a tuple of ToolActions")
    if strange := [motion for motion in chunk if not isinstance(motion, ToolAction)]:
        raise TypeError(f"controller: act returned a {_kind(strange[0])} among its ToolActions")
    if not chunk:
        raise ValueError("controller: a chunk must hold at least one action, got none")
    return tuple(chunk)


def _kind(value: object) -> str:
    return type(value).__name__
