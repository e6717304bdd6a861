"""Planners of demonstrations: one gives random corrections, one always the same instruction.

The expert demonstrates the 18 corrections that the first one gives at random times.
SRT-H's controller gets one string; during a correction, the task waits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from controller.expert.skills import among_tissue
from controller.expert.traction import PULL_MAX_N
from planner.base import Planner, hears_of_success
from planner.correction import CORRECTIONS, Correction
from planner.instruction import Instruction
from tissue_sim.outcome.predicates import gallbladder_held, right_arm_back, tubes_spread
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import CLIPS_LEFT_MAX
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

if TYPE_CHECKING:
    from tissue_sim.world import World

# Assumed, all of them.
CHANCE = 0.25  # of a correction at each plan, which is made once a second
LASTS_S = (1, 2)
BETWEEN_S = 6.0  # minimum time from the end of one to the next
RARITY = {  # weight of each when it is possible; rarely possible ones get a larger weight
    ("left", None): 3.0,
    ("left", "open"): 16.0,
    ("left", "close"): 8.0,
    ("right", None): 1.0,
    ("right", "open"): 8.0,
    ("right", "close"): 8.0,
    ("both", "open"): 8.0,
    ("both", "close"): 8.0,
}
RARITY_WHILE_SHUT = RARITY | {("right", "open"): 0.3}  # then only this one is often possible
CLIPS_TO_LOSE = CLIPS_LEFT_MAX - 1  # the last one is left to accidents
DISTANCE_M = (0.001, 0.020)  # of a correction of an arm
BESIDE_TISSUE_M, HOLDING_M = 0.008, 0.004  # the largest distance of a tool there
WAITING_MAX_RAD = 0.2  # right jaws at work are open wider


class PlannerInterjecting:
    """Passes on another planner's instructions, with random corrections.

    The other planner's clock stops during a correction: a task that waits has not failed.
    """

    privileged = True

    def __init__(
        self, planner: Planner[Observation], world: World, rng: np.random.Generator
    ) -> None:
        self._planner, self._world, self._rng = planner, world, rng
        self.hears_of_success = hears_of_success(planner)
        self.reset()

    def reset(self) -> None:
        """Forget the episode so far, but continue the random numbers."""
        self._planner.reset()
        self._correction: Correction | None = None
        self._until_s = self._waited_s = 0.0

    def plan(self, observation: Observation) -> Instruction:
        """Return the other planner's instruction, sometimes with a correction."""
        now_s = observation.time_s
        said = self._planner.plan(replace(observation, time_s=now_s - self._waited_s))
        said = replace(said, time_s=now_s)
        if said.hold:
            return said
        if self._correction is not None and now_s >= self._until_s - 1e-9:
            self._correction = None
        elif now_s >= self._until_s + BETWEEN_S and self._rng.uniform() < CHANCE:
            able = [c for c in CORRECTIONS if is_harmless(c, self._world)]
            rarities = RARITY_WHILE_SHUT if _waits_shut(self._world) else RARITY
            rarity = np.array([rarities[c.arm, c.jaw] for c in able])
            self._correction = able[self._rng.choice(len(able), p=rarity / rarity.sum())]
            lasts_s = float(self._rng.choice(LASTS_S))
            self._until_s, self._waited_s = now_s + lasts_s, self._waited_s + lasts_s
        return replace(said, correction=self._correction)


@dataclass(frozen=True, kw_only=True)
class PlannerFixed:
    """A planner that always gives the same instruction."""

    instruction: Instruction
    hears_of_success: bool = False

    def plan(self, observation: Observation) -> Instruction:
        """Return the same instruction for every observation."""
        return self.instruction

    def reset(self) -> None:
        """Do nothing: the planner has no state."""


def is_harmless(correction: Correction, world: World) -> bool:
    """Return whether the correction can be carried out now without injury or violated interlock."""
    arms = ("left", "right") if correction.arm == "both" else (correction.arm,)
    return all(_ALLOWED[arm, correction.jaw](world) for arm in arms)


def harmless_m(correction: Correction, world: World, rng: np.random.Generator) -> float:
    """Draw a distance for a harmless correction of an arm, uniform in its logarithm."""
    (arm,) = correction.rows
    least_m, most_m = DISTANCE_M
    if arm == LEFT_ARM and gallbladder_held(world):
        most_m = HOLDING_M
    elif among_tissue(arm, world):
        most_m = BESIDE_TISSUE_M
    return float(np.exp(rng.uniform(np.log(least_m), np.log(most_m))))


def _grasper_may_open(world: World) -> bool:
    """Return whether the grasper can open, so that it can grasp the released tissue again."""
    return not gallbladder_held(world) or not world.record.clips


def _grasper_may_move(world: World) -> bool:
    """Return whether the grasper can move: while holding, only from its proper place."""
    if not gallbladder_held(world):
        return True
    return tubes_spread(world.tubes) and world.record.grasp.traction_n <= PULL_MAX_N


def _right_jaws_may_close(world: World) -> bool:
    """Return whether the right jaws can close: a loaded applier loses its clip."""
    lost = sum(clip.lost for clip in world.record.clips)
    return right_arm_back(world) and (not world.record.clip_loaded or lost < CLIPS_TO_LOSE)


def _right_arm_may_move(world: World) -> bool:
    """Return whether the right arm can move: closed jaws would drag a tube along."""
    return world.record.jaws_opened or right_arm_back(world)


def _waits_shut(world: World) -> bool:
    """Return whether the grasper holds and the right jaws are shut, not at work."""
    return gallbladder_held(world) and bool(world.arms.joints[RIGHT_ARM, 6] < WAITING_MAX_RAD)


_ALLOWED = {
    ("left", None): _grasper_may_move,
    ("left", "open"): _grasper_may_open,
    ("left", "close"): lambda world: not gallbladder_held(world),
    ("right", None): _right_arm_may_move,
    ("right", "open"): lambda _: True,
    ("right", "close"): _right_jaws_may_close,
}
