"""Define the operating field's axes in the endoscope's view, in the world frame.

The world's origin is the centre of the field, +x is the surgeon's right, +y away from the surgeon,
+z up. The nominal endoscope looks down at the field by `NOMINAL_PITCH_RAD`.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array, pose

NOMINAL_PITCH_RAD = np.deg2rad(35.0)  # assumed: typical umbilical port over the field


def view_axes(pitch_rad: float = NOMINAL_PITCH_RAD, yaw_rad: float = 0.0) -> Array:
    """Return (3, 3) columns image left, image up and away, in the world frame."""
    c, s = np.cos(pitch_rad), np.sin(pitch_rad)
    level = np.array([[-1.0, 0.0, 0.0], [0.0, s, c], [0.0, c, -s]]).T
    cy, sy = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]]) @ level


LEFT, UP, AWAY = view_axes().T
RIGHT = -LEFT


def field_point(right_m: float, up_m: float, away_m: float) -> Array:
    """Return a point of the field, given along the field's axes, in the world frame (3,)."""
    return right_m * RIGHT + up_m * UP + away_m * AWAY


def endoscope_pose(pitch_rad: float, yaw_rad: float, distance_m: float) -> Array:
    """Return `T_world_endoscope` (4, 4): +x left, +y up, +z away, towards the field's centre."""
    axes = view_axes(pitch_rad, yaw_rad)
    return pose(axes, -distance_m * axes[:, 2])
