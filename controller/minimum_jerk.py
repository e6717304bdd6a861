"""Move a tool smoothly from pose to pose.

The source is Flash and Hogan, "The coordination of arm movements", 1985:
s = 10 t^3 - 15 t^4 + 6 t^5.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tissue_sim.frames import Array, exponential, pose, rotation_vector
from tissue_sim.periods import CONTROL_PERIOD_S

PEAK_SPEED_M_S = 0.040
PEAK_TURN_RAD_S = 1.2
PEAK = 1.875  # of ds/dt, at half time


def progress(t: Array) -> Array:
    """Return the share of the path at share t of the time."""
    return t**3 * (10.0 - 15.0 * t + 6.0 * t**2)


def between(T_start: Array, T_end: Array, share: float) -> Array:
    """Return the pose (4, 4) at a share of a straight path that turns about one axis."""
    turn = rotation_vector(T_start[:3, :3].T @ T_end[:3, :3])
    position = T_start[:3, 3] + share * (T_end[:3, 3] - T_start[:3, 3])
    return pose(T_start[:3, :3] @ exponential(share * turn), position)


def minimum_jerk(T_start: Array, T_end: Array) -> Iterator[Array]:
    """Yield poses (4, 4), one per control step, with the end but without the start."""
    length = np.linalg.norm(T_end[:3, 3] - T_start[:3, 3])
    turn = np.linalg.norm(rotation_vector(T_start[:3, :3].T @ T_end[:3, :3]))
    least_s = PEAK * max(length / PEAK_SPEED_M_S, turn / PEAK_TURN_RAD_S)
    steps = max(1, int(np.ceil(least_s / CONTROL_PERIOD_S)))
    for share in progress(np.linspace(0.0, 1.0, steps + 1)[1:]):
        yield between(T_start, T_end, float(share))
