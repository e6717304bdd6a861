"""Define a controller's output: hybrid-relative motions of both tools, a chunk at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array

ACTION_SIZE = 20
PARALLEL = 1e-6  # squared area between two columns below which they span no rotation; assumed


@dataclass(frozen=True, kw_only=True)
class ToolAction:
    """The motion of one control step, relative to the last commanded pose. Rows: left, right arm.

    The hybrid frame is SRT's: translation in the endoscope's frame, rotation in the tool's.

    Attributes:
        move_endoscope_m: (2, 3) change of the tip's position.
        turn_tool: (2, 6) change of orientation, first two columns of the rotation matrix.
        jaw_rad: (2,) wanted total opening; below zero the fingers press on each other.

    Each field accepts anything that numpy reads, or a tensor of any device. The action keeps a
    read-only copy, so that the motion cannot be changed afterwards.

    Raises:
        ValueError: A field has no numbers, has another shape or is not finite, or two columns
            are parallel.
    """

    move_endoscope_m: Array
    turn_tool: Array
    jaw_rad: Array

    def __post_init__(self) -> None:
        for name, shape in (("move_endoscope_m", (2, 3)), ("turn_tool", (2, 6)), ("jaw_rad", (2,))):
            given = getattr(self, name)
            value = _numbers(given)
            if value is None or value.shape != shape or not np.isfinite(value).all():
                raise ValueError(f"action: {name} must be {shape} finite numbers, got {given!r}")
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        if not all(_span(six) for six in self.turn_tool.tolist()):
            raise ValueError(
                "action: each row of turn_tool must be two columns that are not parallel; no turn"
                f" is (1, 0, 0, 0, 1, 0), got {self.turn_tool!r}"
            )

    def vector(self) -> Array:
        """Return (`ACTION_SIZE`,): move, turn and jaw of the left arm, then of the right."""
        rows = (self.move_endoscope_m, self.turn_tool, np.reshape(self.jaw_rad, (2, 1)))
        return np.concatenate(rows, axis=1).ravel()

    def with_arms(self, arms: NDArray[np.bool_], own: ToolAction) -> ToolAction:
        """Return the action in which the marked arms (2,) follow another action."""
        return ToolAction(
            move_endoscope_m=np.where(arms[:, None], own.move_endoscope_m, self.move_endoscope_m),
            turn_tool=np.where(arms[:, None], own.turn_tool, self.turn_tool),
            jaw_rad=np.where(arms, own.jaw_rad, self.jaw_rad),
        )


def _numbers(given: Any) -> Array | None:
    """Return a copy as an array of floats; None if the values are no real numbers."""
    try:
        if hasattr(given, "detach"):  # a tensor of PyTorch
            given = given.detach().cpu().double()
        array = np.asarray(given)
        return np.array(array, float) if array.dtype.kind in "iuf" else None
    except (TypeError, ValueError, RuntimeError):  # ragged, or tensors of a graph in a list
        return None


def _span(six: list[float]) -> bool:
    """Return whether two columns (6,) span a plane, so that they give a rotation."""
    ax, ay, az, bx, by, bz = six
    return (ay * bz - az * by) ** 2 + (az * bx - ax * bz) ** 2 + (ax * by - ay * bx) ** 2 > PARALLEL


Chunk = tuple[ToolAction, ...]


def hold(jaw_rad: Array) -> ToolAction:
    """Return the action that stays at the commanded pose, with jaws at `jaw_rad` (2,)."""
    return ToolAction(
        move_endoscope_m=np.zeros((2, 3)),
        turn_tool=np.tile([1.0, 0.0, 0.0, 0.0, 1.0, 0.0], (2, 1)),
        jaw_rad=np.asarray(jaw_rad, float),
    )
