"""A person's hand on one arm: it leads the tip to a goal, through driver and safety filter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from controller.action import ToolAction
from controller.expert.motion import Goal, chunk_towards
from tissue_sim.frames import Array
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

if TYPE_CHECKING:
    from tissue_sim.world import World

REACH_M = 1.0  # from the world's origin, beyond any patient; assumed
SPEED_M_S = 0.03  # assumed: a surgeon's, with care


@dataclass(frozen=True, kw_only=True)
class GuidedArm:
    """A goal to which a person's hand leads one arm.

    Attributes:
        arm: `LEFT_ARM` or `RIGHT_ARM`.
        T_world_goal: (4, 4) pose of its tool.
        jaw_rad: Total opening.

    Raises:
        ValueError: There is no such arm, or the goal is no pose within `REACH_M` of the organ.
    """

    arm: int
    T_world_goal: Array
    jaw_rad: float

    def __post_init__(self) -> None:
        T = np.asarray(self.T_world_goal, float)
        R = T[:3, :3]
        is_turn = T.shape == (4, 4) and np.allclose(R.T @ R, np.eye(3), atol=1e-3)
        is_turn = is_turn and np.linalg.det(R) > 0.0
        if self.arm not in (LEFT_ARM, RIGHT_ARM) or not is_turn:
            raise ValueError(f"arm {self.arm!r} cannot be led to {T.tolist()}, which is no pose")
        if not np.linalg.norm(T[:3, 3]) <= REACH_M or not abs(self.jaw_rad) <= np.pi:
            raise ValueError(f"{T[:3, 3].tolist()} m and {self.jaw_rad!r} rad are out of reach")

    def lead(self, action: ToolAction, world: World) -> ToolAction:
        """Return the action with this arm's motion replaced by one towards the goal."""
        goals = [Goal(), Goal()]
        goals[self.arm] = Goal(
            T_world_tool=self.T_world_goal, speed_m_s=SPEED_M_S, jaw_rad=self.jaw_rad
        )
        own = chunk_towards(
            (goals[0], goals[1]),
            world.arms.T_world_tool(),
            world.target[:, 6],
            world.T_world_endoscope[:3, :3],
            world.body.velocity_m_s,
        )[0]
        return action.with_arms(np.arange(2) == self.arm, own)
