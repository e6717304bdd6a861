"""A controller's output: hybrid-relative motions of both tools, a chunk at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_sim.frames import Array

ACTION_SIZE = 20


@dataclass(frozen=True, kw_only=True)
class ToolAction:
    """The motion of one control step, relative to the last commanded pose. Rows: left, right arm.

    The hybrid frame is SRT's: translation in the endoscope's frame, rotation in the tool's.

    Attributes:
        move_endoscope_m: (2, 3) change of the tip's position.
        turn_tool: (2, 6) change of orientation, first two columns of the rotation matrix.
        jaw_rad: (2,) wanted total opening; below zero the fingers press on each other.
    """

    move_endoscope_m: Array
    turn_tool: Array
    jaw_rad: Array

    def __post_init__(self) -> None:
        for name, shape in (("move_endoscope_m", (2, 3)), ("turn_tool", (2, 6)), ("jaw_rad", (2,))):
            value = np.asarray(getattr(self, name))
            if value.shape != shape or not np.isfinite(value).all():
                raise ValueError(f"action: {name} must be {shape} finite numbers, got {value!r}")

    def vector(self) -> Array:
        """Return (`ACTION_SIZE`,): move, turn and jaw of the left arm, then of the right."""
        rows = (self.move_endoscope_m, self.turn_tool, np.reshape(self.jaw_rad, (2, 1)))
        return np.concatenate(rows, axis=1).ravel()


Chunk = tuple[ToolAction, ...]


def hold(jaw_rad: Array) -> ToolAction:
    """Return the action that stays at the commanded pose, with jaws at `jaw_rad` (2,)."""
    return ToolAction(
        move_endoscope_m=np.zeros((2, 3)),
        turn_tool=np.tile([1.0, 0.0, 0.0, 0.0, 1.0, 0.0], (2, 1)),
        jaw_rad=np.asarray(jaw_rad, float),
    )
