"""What the safety filter is told: the commanded arms, and the exact state of the simulation."""

from __future__ import annotations

import numpy as np

from controller.links import Rates
from controller.remote_centre import shaft_offset_m
from controller.safety.arm_motion import arm_motion
from controller.safety.bounds import N_MOTION
from controller.safety.exemption import worked_on
from controller.safety.geometry.collision import NO_LINK, CollisionModel, NearPairs
from controller.safety.geometry.link_cores import N_LINK
from controller.safety.obstacles import Surroundings, registered, surroundings_of
from controller.safety.proof import safe_share
from controller.safety.situation import Situation
from planner.instruction import Instruction
from tissue_sim.frames import Array
from tissue_sim.outcome.clip_rule import clips_needed
from tissue_sim.outcome.jaws import between_jaws
from tissue_sim.surgery.clip import retention_n
from tissue_sim.thresholds import TEST_PULL_N
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.world import World

ARMS = (LEFT_ARM, RIGHT_ARM)


class ExactSense:
    """Tells the filter the exact state of one patient. Privileged; policies do not receive it."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._rigid = registered(world)
        self._T_world_rcm = world.arms.T_world_rcm
        self._model = CollisionModel(self._rigid, self._T_world_rcm)
        self._surroundings: Surroundings = surroundings_of(world)

    def see(self, start: Array, rate: Array, asked: Array, instruction: Instruction) -> Situation:
        """Return the situation when joints (2, 7) are asked for and `start` was commanded."""
        world, instruments = self._world, self._world.arms.mounted
        self._surroundings = surroundings_of(world)
        near = self._model.near(start, instruments, self._surroundings)
        motion = (asked - start).ravel()
        arms = arm_motion(start, motion, instruments, self._T_world_rcm)
        closes = asked[RIGHT_ARM, 6] < start[RIGHT_ARM, 6]
        between = self._between_jaws() if closes else frozenset[str]()
        return Situation(
            step_s=world.config.control_step_s,
            instruments=instruments,
            start=start,
            rate=rate,
            asked=asked,
            arms=arms,
            near=near,
            parting=_parting(near, arms.rates),
            tool_force_n=world.tool_forces_n(),
            pinch_n=world.record.grasp.pinch_n,
            shaft_offset_m=self._shaft_offset_m(),
            instruction=instruction,
            worked_on=worked_on(instruction.task, world),
            between_jaws=between,
            lacking_clips=frozenset(filter(self._lacks_clips, between)),
        )

    def safe_share(self, situation: Situation, motion: Array) -> float:
        """Return `proof.safe_share` in the last surroundings."""
        return safe_share(self._model, self._surroundings, situation, motion)

    def _between_jaws(self) -> frozenset[str]:
        arms = self._world.arms
        tool = arms.mounted[RIGHT_ARM].name
        return between_jaws(self._world.tubes, arms.T_world_tool()[RIGHT_ARM], tool)

    def _shaft_offset_m(self) -> Array:
        """Return (2,) the offsets of the present shafts."""
        shafts = self._world.tissue.T_world_links()[::N_LINK].astype(float)
        from_rcm_m = (shafts[:, :3, 3] - self._T_world_rcm[:, :3, 3]).tolist()
        axes = shafts[:, :3, 2].tolist()
        return np.array([shaft_offset_m(*line) for line in zip(from_rcm_m, axes, strict=True)])

    def _lacks_clips(self, structure: str) -> bool:
        world = self._world
        clips = [c for c in world.record.clips if not c.lost and c.on(structure)]
        hold = sum(retention_n(world.tubes, clip) >= TEST_PULL_N for clip in clips)
        return hold < clips_needed(structure, world.tubes.length_m.get(structure, np.inf))


def _parting(near: NearPairs, moving: Rates) -> Array:
    """Return (n, 14) from a motion to the change of each pair's distance."""
    n, normal = len(near.arm), near.normal
    parting = np.zeros((n, len(ARMS), 7))
    parting[np.arange(n), near.arm] = moving.speeds_along(
        near.arm, near.link, near.on_instrument_m, normal
    )
    if len(other := np.flatnonzero(near.other_link != NO_LINK)):
        parting[other, RIGHT_ARM] = moving.speeds_along(
            np.full(len(other), RIGHT_ARM),
            near.other_link[other],
            near.on_obstacle_m[other],
            -normal[other],
        )
    return parting.reshape(n, N_MOTION)
