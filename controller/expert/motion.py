"""Move tools straight towards goal poses, as a chunk of small relative steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controller.action import Chunk, ToolAction
from tissue_sim.frames import Array, exponential, rotation_to_6d, rotation_vector
from tissue_sim.periods import CONTROL_PERIOD_S

CHUNK_STEPS = 3
TURN_SPEED_RAD_S, JAW_SPEED_RAD_S = 1.2, 1.0  # assumed
STILL = np.zeros(3)


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
