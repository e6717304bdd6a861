"""General inverse kinematics: the pose within the joint limits that is nearest to a target.

`controller.kinematics` has the closed form for poses in reach. This one solves a bounded
least-squares problem with Ipopt through CasADi. It also has a solution where the closed form has
none: out of reach, beyond a joint limit, or singular.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import asin, hypot, pi, sin, sqrt
from threading import Lock

import casadi as ca
import numpy as np

from controller import symbolic
from controller.kinematics import require_pose
from tissue_sim.frames import Array
from tissue_sim.tools.instruments import Instrument
from tissue_sim.tools.psm import forward_kinematics, joint_limits

METRES_PER_RADIAN = 0.02  # assumed: about what a radian moves the far end of a finger
_REACHED = 1e-6  # rad
_STRAIGHT = tuple(np.array([0.0, 0.0, 0.12, roll, 0.0, 0.0]) for roll in (0.0, pi))
_MAX_ITERATIONS = 100
_ONE_AT_A_TIME = Lock()  # Ipopt's linear solver (MUMPS) crashes in two threads at once
_TOLERANCE = 1e-13  # of a square: joints at a limit stop short of it by about the root


@dataclass(frozen=True, kw_only=True)
class NearestPose:
    """Joints within the limits, and the remaining error between tool and target."""

    joints: Array  # (6,)
    position_error_m: float
    rotation_error_rad: float

    @property
    def weighted_error(self) -> float:
        """Return the minimised error (rad): the rotation's chord and the position as an angle."""
        return hypot(
            self.position_error_m / METRES_PER_RADIAN, 2 * sin(self.rotation_error_rad / 2)
        )


def solve_inverse(T_rcm_tool: Array, instrument: Instrument, near: Array) -> NearestPose:
    """Return the joints (6,) whose pose is nearest to a target, searched from `near` (6,).

    A local search (2 to 6 ms). If it does not reach the target, two more start from a straight
    tool at either side of the roll, and the nearest result is returned.

    Raises:
        ValueError: the target or `near` is not finite, or the target is over 10 m away.
    """
    require_pose(T_rcm_tool)
    near = np.asarray(near, float)
    if near.shape != (6,) or not np.isfinite(near).all():
        raise ValueError(f"near must be six finite joints, not {near}")
    nearest = _search(T_rcm_tool, instrument, near)
    if nearest.weighted_error < _REACHED:
        return nearest
    others = [_search(T_rcm_tool, instrument, start) for start in _STRAIGHT]
    return min(nearest, *others, key=lambda found: found.weighted_error)


def _search(target: Array, instrument: Instrument, start: Array) -> NearestPose:
    lower, upper = joint_limits(instrument).T
    with _ONE_AT_A_TIME:
        solution = _solver(instrument)(x0=start, p=target, lbx=lower, ubx=upper)
    joints = np.clip(solution["x"].full().ravel(), lower, upper)  # Ipopt relaxes by 1e-8
    T = forward_kinematics(joints, instrument)
    chord = np.linalg.norm(T[:3, :3] - target[:3, :3]) / sqrt(2)
    return NearestPose(
        joints=joints,
        position_error_m=float(np.linalg.norm(T[:3, 3] - target[:3, 3])),
        rotation_error_rad=2 * asin(min(chord / 2, 1.0)),
    )


@cache
def _solver(instrument: Instrument) -> ca.Function:
    joints, target = ca.SX.sym("joints", 6), ca.SX.sym("T_rcm_tool", 4, 4)
    difference = symbolic.tool_pose(instrument).symbolic(joints) - target
    position = ca.sumsqr(difference[:3, 3]) / METRES_PER_RADIAN**2
    rotation = ca.sumsqr(difference[:3, :3]) / 2  # its chord squared, 4 sin^2(angle / 2)
    problem = {"x": joints, "p": target, "f": position + rotation}
    ipopt = {
        "max_iter": _MAX_ITERATIONS,
        "tol": _TOLERANCE,
        "compl_inf_tol": _TOLERANCE,
        "print_level": 0,
        "sb": "yes",
    }
    options = {"ipopt": ipopt, "print_time": False, "error_on_fail": False}
    return ca.nlpsol("nearest_pose", "ipopt", problem, options)
