"""Build the safety filter's input from the commanded arms, the observation and a registration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from controller.links import Rates
from controller.safety.arm_motion import arm_motion
from controller.safety.bounds import N_MOTION
from controller.safety.clips_seen import crowded_by_clips, lacking_clips
from controller.safety.exemption import worked_on
from controller.safety.geometry.collision import NO_LINK, CollisionModel, NearPairs
from controller.safety.giving_way import GivingWay, coming_m_s
from controller.safety.jaws_seen import between_jaws_seen, partly_between_seen
from controller.safety.obstacles import RigidSurroundings, Surroundings, registered
from controller.safety.proof import safe_share
from controller.safety.seen_obstacles import ObstaclesSeen
from controller.safety.situation import Situation
from planner.instruction import Instruction
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS

if TYPE_CHECKING:
    from tissue_sim.world import World

ARMS = (LEFT_ARM, RIGHT_ARM)


@dataclass(frozen=True, kw_only=True)
class Registration:
    """The measurements that are made once, before the operation.

    Attributes:
        rigid: Surfaces of the liver and of the wall around the ports.
        T_world_rcm: (2, 4, 4) poses of the remote centres.
        step_s: Length of a control step.
    """

    rigid: RigidSurroundings
    T_world_rcm: Array
    step_s: float


def registration_of(world: World) -> Registration:
    """Return the registration of a patient on the table."""
    return Registration(
        rigid=registered(world),
        T_world_rcm=world.arms.T_world_rcm,
        step_s=world.config.control_step_s,
    )


class FilterSense:
    """Builds the filter's situation of one patient, from observations alone."""

    def __init__(self, registration: Registration) -> None:
        self._registration, self._obstacles = registration, ObstaclesSeen()
        self._between, self._giving_way = frozenset[str](), GivingWay()
        self._model = CollisionModel(registration.rigid, registration.T_world_rcm)

    def build(
        self,
        start: Array,
        rate: Array,
        asked: Array,
        instruction: Instruction,
        observation: Observation,
    ) -> Situation:
        """Return the situation for requested joints (2, 7) after the command `start`."""
        instruments = (
            INSTRUMENTS[observation.tools[LEFT_ARM]],
            INSTRUMENTS[observation.tools[RIGHT_ARM]],
        )
        self._surroundings: Surroundings = self._obstacles.follow(observation)
        near = self._model.near(start, instruments, self._surroundings)
        velocity = self._giving_way.follow(observation.time_s, self._surroundings.capsules)
        motion = (asked - start).ravel()
        arms = arm_motion(start, motion, instruments, self._registration.T_world_rcm)
        closes = asked[RIGHT_ARM, 6] < start[RIGHT_ARM, 6]
        self._between = (
            between_jaws_seen(observation, self._between) if closes else frozenset[str]()
        )
        return Situation(
            step_s=self._registration.step_s,
            instruments=instruments,
            start=start,
            rate=rate,
            asked=asked,
            arms=arms,
            near=near,
            parting=_parting(near, arms.rates),
            coming_m_s=coming_m_s(near, velocity, observation.pinch_n),
            tool_force_n=observation.forces_n @ observation.T_world_endoscope[:3, :3].T,
            pinch_n=observation.pinch_n,
            shaft_offset_m=observation.shaft_offset_m,
            instruction=instruction,
            worked_on=worked_on(instruction.task, observation),
            between_jaws=self._between,
            lacking_clips=self._between and self._between & lacking_clips(observation),
            crowded=self._between and crowded_by_clips(observation, self._between),
            partly=partly_between_seen(observation, self._between),
        )

    def safe_share(self, situation: Situation, motion: Array) -> float:
        """Return `proof.safe_share` in the last surroundings."""
        return safe_share(self._model, self._surroundings, situation, motion)


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
