"""Complete a grasp that holds: close the jaws, pull until the tubes are straight, and then rest.

A policy learns from an expert that presses until the jaws are closed, and pulls until the tubes are
straight. The policy stops slightly before either, or pulls on. A rule on the observation says
whether jaws are closed and tubes straight. Therefore a rule decides on both; the policy decides
everything else.
"""

from __future__ import annotations

import numpy as np

from controller.diffusion.chunk_frame import JAW, MOVE, TURN
from controller.diffusion.rules.holding import UNTURNED
from controller.diffusion.scene.scene import Scene
from planner.procedure.task import Task
from planner.scene.predicates import (
    FIRM_TRACTION_N,
    is_about,
    is_low,
    lacking_m,
    pulls,
    traction_n,
)
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import GRASP_MAX_JAW_RAD, HELD_PINCH_N
from tissue_sim.tools.arms import LEFT_ARM

CLOSE_RAD = GRASP_MAX_JAW_RAD - 0.05  # the expert's angle
JAW_STEP_RAD = 0.034  # by which the policy opens or closes jaws in a control step; measured
WIDE_RAD = 1.0  # as the grasper approaches the gallbladder
MOST_RAD = 0.05  # by which a chunk closes the jaws at most; assumed
MOST_PINCH_N = 6.0  # no rule presses harder, far below damage; the expert's grasp has 3 N; assumed
RESTS_M = 5e-4  # a chunk that moves the left tip by less rests; assumed
MOST_M = 1e-3  # by which a chunk's end is moved at most; assumed
SLACK_M = 4e-4  # by which a chunk's end is moved while the pull is too weak; assumed
MOST_TRACTION_N = 1.5  # no rule pulls harder; the expert's grasp has 0.3 to 1 N; assumed


def complete_grasp(chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
    """Return a chunk (n, 20) that closes jaws which hold, and pulls at a tube that is not straight.

    Jaws at the gallbladder's neck open instead, at their place. An arm with a good observed grasp
    rests. Open jaws close if they rest where a grasp holds.

    Otherwise the chunk stays unchanged where the left arm does not hold the gallbladder. The rule
    adds no pull to an arm that moves anyway.

    The arguments are those of every rule (`chunk_rules.Rule`).
    """
    del commanded
    if not task.grasps:
        return chunk
    arms = chunk.reshape(len(chunk), 2, -1).copy()
    now, steps = scene.observation, np.arange(1, len(arms) + 1)
    if is_low(now):
        left, opening = arms[:, LEFT_ARM], now.joints[LEFT_ARM, -1] + JAW_STEP_RAD * steps
        left[:, JAW] = np.maximum(left[:, JAW], np.minimum(opening, WIDE_RAD))
        left[:, MOVE], left[:, TURN] = 0.0, UNTURNED
        return arms.reshape(chunk.shape)
    share = steps / len(arms)
    if scene.is_grasped:
        arms[:, LEFT_ARM, MOVE], arms[:, LEFT_ARM, TURN] = 0.0, UNTURNED
    elif np.linalg.norm(arms[-1, LEFT_ARM, MOVE]) <= RESTS_M:
        arms[:, LEFT_ARM, MOVE] += share[:, None] * _lacking_m(now)
        if is_about(now):
            closing = now.joints[LEFT_ARM, -1] - JAW_STEP_RAD * steps
            arms[:, LEFT_ARM, JAW] = np.minimum(arms[:, LEFT_ARM, JAW], closing)
    arms[:, LEFT_ARM, JAW] -= share * _too_wide_rad(now)
    return arms.reshape(chunk.shape)


def _too_wide_rad(observation: Observation) -> float:
    """Return the angle by which jaws that hold should close."""
    if not HELD_PINCH_N <= observation.pinch_n <= MOST_PINCH_N:
        return 0.0
    return float(np.clip(observation.joints[LEFT_ARM, -1] - CLOSE_RAD, 0.0, MOST_RAD))


def _lacking_m(observation: Observation) -> Array:
    """Return the missing pull (3,) along the chord of the less straight tube."""
    if not pulls(observation) or traction_n(observation) > MOST_TRACTION_N:
        return np.zeros(3)
    lacks_m = lacking_m(observation)
    k = int(lacks_m.argmax())
    slack_m = SLACK_M if traction_n(observation) < FIRM_TRACTION_N else 0.0
    tube_m = observation.tubes_m[k]
    chord_m = tube_m[-1] - tube_m[0]
    return np.clip(lacks_m[k], slack_m, MOST_M) * chord_m / np.linalg.norm(chord_m)
