"""Move tools to goal poses: straight in small relative steps, or smoothly; jaws keep some room.

The smooth motion is of minimum jerk: Flash and Hogan, "The coordination of arm movements", 1985:
s = 10 t^3 - 15 t^4 + 6 t^5.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from controller.action import Chunk, ToolAction
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array, exponential, pose, rotation_to_6d, rotation_vector

CHUNK_STEPS = 3
TURN_SPEED_RAD_S, JAW_SPEED_RAD_S = 1.2, 1.0  # assumed
STILL = np.zeros(3)
PHASE_MAX_S = 10.0  # longest motion to a goal; assumed

# The room that the expert leaves around its open jaws, which policies get as input
CLEARANCE_M = 0.0018  # between tube and finger on either side
OFF_CENTRE_M = 0.0013  # the tube nearer to one finger, so that the other finger's side stays free
FIRM_ROOM_M = 0.0006  # to a structure at risk or the other arm: the filter keeps 0.5 mm


@dataclass(frozen=True, kw_only=True)
class Goal:
    """The goal pose of a tool and its speed; None means to stay as commanded.

    Attributes:
        T_world_tool: (4, 4) goal pose.
        jaw_rad: Wanted total opening of the jaws.
        speed_m_s: Speed of the tip.
    """

    T_world_tool: Array | None = None
    jaw_rad: float | None = None
    speed_m_s: float = 0.03


def chunk_towards(
    goals: tuple[Goal, Goal],
    T_world_tool: Array,
    jaw_rad: Array,
    R_world_endoscope: Array,
    drift_world_m_s: Array = STILL,
) -> Chunk:
    """Return motions of both arms from (2, 4, 4) and commanded jaws (2,) towards their goals.

    Goals, and arms without a goal, move at `drift_world_m_s` (3,), because the patient breathes.
    """
    drift_m = CONTROL_PERIOD_S * drift_world_m_s
    T, jaw = T_world_tool.copy(), jaw_rad.copy()
    chunk = []
    for _ in range(CHUNK_STEPS):
        moves, turns = np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1))
        for arm, goal in enumerate(goals):
            if goal.jaw_rad is not None:
                most = JAW_SPEED_RAD_S * CONTROL_PERIOD_S
                jaw[arm] += np.clip(goal.jaw_rad - jaw[arm], -most, most)
            if goal.T_world_tool is not None:
                moves[arm], turns[arm] = _step(T[arm], goal.T_world_tool, goal.speed_m_s)
                T[arm, :3, 3] += moves[arm]
                T[arm, :3, :3] = T[arm, :3, :3] @ turns[arm]
        chunk.append(
            ToolAction(
                move_endoscope_m=(moves + drift_m) @ R_world_endoscope,
                turn_tool=np.stack([rotation_to_6d(R) for R in turns]),
                jaw_rad=jaw.copy(),
            )
        )
    return tuple(chunk)


def before(T_world_tool: Array, back_m: float) -> Array:
    """Return the pose moved back along the tool's own axis."""
    T = T_world_tool.copy()
    T[:3, 3] -= back_m * T[:3, 2]
    return T


def distance(T: Array, goal: Array) -> tuple[float, float]:
    """Return the distance between two poses: of the tips (m) and of the orientations (rad)."""
    turn = rotation_vector(T[:3, :3].T @ goal[:3, :3])
    return float(np.linalg.norm(goal[:3, 3] - T[:3, 3])), float(np.linalg.norm(turn))


def _step(T: Array, goal: Array, speed_m_s: float) -> tuple[Array, Array]:
    """Return one control step's translation (world, m) and rotation (tool frame)."""
    away = goal[:3, 3] - T[:3, 3]
    turn = rotation_vector(T[:3, :3].T @ goal[:3, :3])
    return (
        away * _share(float(np.linalg.norm(away)), speed_m_s),
        exponential(turn * _share(float(np.linalg.norm(turn)), TURN_SPEED_RAD_S)),
    )


def _share(left: float, speed: float) -> float:
    """Return the share of the remaining way that one step covers; the cap slows the end."""
    return min(0.35, speed * CONTROL_PERIOD_S / left) if left > 1e-9 else 0.0


# Minimum jerk

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
