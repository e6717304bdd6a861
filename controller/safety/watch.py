"""What the filter sees: the arms as commanded, and the world as a tracker without error has it."""

from __future__ import annotations

import numpy as np

from controller.links import point_jacobians, tool_jacobian
from controller.remote_centre import shaft_offset_m
from controller.safety.bounds import N_MOTION
from controller.safety.collision import NO_LINK, CollisionModel, NearPairs
from controller.safety.link_cores import N_LINK
from controller.safety.proof import safe_share
from controller.safety.situation import Situation
from controller.safety.surroundings import Surroundings, registered, surroundings_of
from planner.criteria import structure_of
from planner.instruction import Instruction
from tissue_sim.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.clip import retention_n
from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.jaws import between_jaws
from tissue_sim.sweep import Indices
from tissue_sim.thresholds import TEST_PULL_N
from tissue_sim.world import World

ARMS = (LEFT_ARM, RIGHT_ARM)


class Watch:
    """Of one patient. Privileged, as a monitor is; what it sees does not reach the policy."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._rigid = registered(world)
        self._T_world_rcm = world.arms.T_world_rcm
        self._T_rcm_world = inverse_pose(world.arms.T_world_rcm)
        self._model = CollisionModel(self._rigid, self._T_world_rcm)
        self._surroundings: Surroundings = surroundings_of(world, self._rigid)

    def see(self, start: Array, rate: Array, asked: Array, instruction: Instruction) -> Situation:
        """The situation in which joints (2, 7) are asked for, `start` having been commanded."""
        world, instruments = self._world, self._world.arms.mounted
        self._surroundings = surroundings_of(world, self._rigid)
        near = self._model.near(start, instruments, self._surroundings)
        closes = asked[RIGHT_ARM, 6] < start[RIGHT_ARM, 6]
        between = self._between_jaws() if closes else frozenset[str]()
        return Situation(
            step_s=world.config.control_step_s,
            instruments=instruments,
            start=start,
            rate=rate,
            asked=asked,
            tool_jacobian=np.stack(
                [tool_jacobian(q[:6], i) for q, i in zip(start, instruments, strict=True)]
            ),
            R_world_rcm=self._T_world_rcm[:, :3, :3],
            near=near,
            parting=self._parting(start, near),
            tool_force_n=world.tool_forces_n(),
            pinch_n=world.record.grasp.pinch_n,
            shaft_offset_m=self._shaft_offset_m(),
            instruction=instruction,
            worked_on=structure_of(instruction.task, world),
            between_jaws=between,
            held_by_clips={tube: self._clips_that_hold(tube) for tube in between},
        )

    def safe_share(self, situation: Situation, motion: Array) -> float:
        """`proof.safe_share` in what was seen last."""
        return safe_share(self._model, self._surroundings, situation, motion)

    def _parting(self, start: Array, near: NearPairs) -> Array:
        """(n, 14) from a motion to the change of each pair's distance."""
        parting = np.zeros((len(near.arm), N_MOTION))
        for arm in ARMS:
            own = near.arm == arm
            columns = slice(7 * arm, 7 * arm + 7)
            parting[own, columns] = self._along(
                start, arm, near.link[own], near.on_instrument_m[own], near.normal[own]
            )
        other = near.other_link != NO_LINK
        parting[other, 7:] -= self._along(
            start, RIGHT_ARM, near.other_link[other], near.on_obstacle_m[other], near.normal[other]
        )
        return parting

    def _along(
        self, start: Array, arm: int, links: Indices, points_m: Array, directions: Array
    ) -> Array:
        """(n, 7) from one arm's joint rates to the speeds of its points along directions."""
        T = self._T_rcm_world[arm]
        instrument = self._world.arms.mounted[arm]
        J = point_jacobians(start[arm], instrument, links, transform(T, points_m))
        return np.einsum("ni,nij->nj", directions @ T[:3, :3].T, J)

    def _between_jaws(self) -> frozenset[str]:
        arms = self._world.arms
        tool = arms.mounted[RIGHT_ARM].name
        return between_jaws(self._world.tubes, arms.T_world_tool()[RIGHT_ARM], tool)

    def _shaft_offset_m(self) -> Array:
        """(2,) of the shafts as they are now."""
        shafts = self._T_rcm_world @ self._world.tissue.T_world_links()[::N_LINK]
        return shaft_offset_m(shafts[:, :3, 3], shafts[:, :3, 2])

    def _clips_that_hold(self, tube: str) -> int:
        world = self._world
        clips = [c for c in world.record.clips if not c.lost and c.on(tube)]
        return sum(retention_n(world.tubes, clip) >= TEST_PULL_N for clip in clips)
