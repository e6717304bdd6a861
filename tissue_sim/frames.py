"""Compute rotations and poses, and define the operating field's axes in the endoscope's view.

Quaternions are wxyz. A pose is `T_parent_child`, a (4, 4) matrix.

The world's origin is the centre of the field, +x is the surgeon's right, +y away from the surgeon,
+z up. The nominal endoscope looks down at the field by `NOMINAL_PITCH_RAD`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def unit(vector: Array) -> Array:
    """Divide a vector by its length, along the last axis."""
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def pose(rotation: Array, position: Array) -> Array:
    """Return the (4, 4) pose of a (3, 3) rotation and a (3,) position."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation, position
    return T


def inverse_pose(T: Array) -> Array:
    """Invert rigid poses (..., 4, 4)."""
    R_t = np.swapaxes(T[..., :3, :3], -1, -2)
    out = np.zeros_like(T)
    out[..., :3, :3] = R_t
    out[..., :3, 3] = -(R_t @ T[..., :3, 3:])[..., 0]
    out[..., 3, 3] = 1.0
    return out


def transform(T: Array, points: Array) -> Array:
    """Transform points (n, 3) from the child frame to the parent frame."""
    return points @ T[:3, :3].T + T[:3, 3]


def rigid_fit(points: Array, moved: Array) -> Array:
    """Return the (4, 4) pose that maps points (n, 3) to `moved`, in least squares.

    Source: Kabsch, "A solution for the best rotation to relate two sets of vectors", 1976.
    """
    middle, moved_middle = points.mean(axis=0), moved.mean(axis=0)
    U, _, Vt = np.linalg.svd((moved - moved_middle).T @ (points - middle))
    R = U @ Vt
    if R[0] @ cross(R[1], R[2]) < 0.0:  # a reflection, not a rotation
        U[:, 2] *= -1.0
        R = U @ Vt
    return pose(R, moved_middle - R @ middle)


def axis_angle(axis: Array, angle_rad: float) -> Array:
    """Return the (3, 3) rotation about an axis (Rodrigues)."""
    x, y, z = unit(np.asarray(axis, float))
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle_rad) * K + (1 - np.cos(angle_rad)) * (K @ K)


def rotation_vector(rotation: Array) -> Array:
    """Return axis times angle (rad) of a (3, 3) rotation; the result is exact up to half a turn."""
    skew = np.array(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        ]
    )
    sine = 0.5 * np.linalg.norm(skew)
    angle = np.arctan2(sine, 0.5 * (np.trace(rotation) - 1.0))
    if sine > 1e-9:
        return skew * (0.5 * angle / sine)
    if angle < 1.0:
        return 0.5 * skew
    column = rotation + np.eye(3)
    return angle * unit(column[:, np.argmax(np.diagonal(column))])


def exponential(vector: Array) -> Array:
    """Return the (3, 3) rotation of a rotation vector (rad)."""
    angle = float(np.linalg.norm(vector))
    return np.eye(3) if angle < 1e-12 else axis_angle(vector, angle)


def rotation_from_6d(six: Array) -> Array:
    """Return the (3, 3) rotation of its first two columns (6,), made orthonormal.

    Source: Zhou et al., "On the continuity of rotation representations in neural networks", 2019.
    """
    x = unit(six[:3])
    y = unit(six[3:] - (six[3:] @ x) * x)
    return np.stack([x, y, cross(x, y)], axis=1)


def cross(a: Array, b: Array) -> Array:
    """Return the cross product of two vectors (3,), as `np.cross` does, in a tenth of the time."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def rotation_to_6d(rotation: Array) -> Array:
    """Return the first two columns of a (3, 3) rotation, as (6,)."""
    return rotation[:, :2].T.reshape(6)


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
