"""What of a task has been done, as the robot sees it. From the observation alone."""

from __future__ import annotations

import numpy as np

from planner.command import TUBES
from planner.seen.next_task import clips_needed_on, clips_on
from planner.task import Task
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.sensing.observation import Observation, tip_to_tubes_m
from tissue_sim.thresholds import (
    GRASP_MAX_JAW_RAD,
    GRASP_MIN_TRACTION_N,
    HELD_PINCH_N,
    RETRACTED_M,
)
from tissue_sim.tools.arms import LEFT_ARM


def is_done(task: Task, seen: Observation) -> bool:
    """Return whether a clip is seen on its tube, a cut as made, or the right tip as back.

    Raises:
        ValueError: the task is to grab: whether that is done cannot be told from one observation.
    """
    if task.tube is None:
        raise ValueError(f"{task.text!r} is not seen to be done")
    if task.goes_back:
        return is_back(seen)
    if task.clip is None:
        return bool(seen.severed[TUBES.index(task.tube)])
    needed = clips_needed_on(task.tube, seen)
    return clips_on(task.tube, seen) >= (needed if task.clip == USUAL_CLIPS else task.clip)


def has_slipped(seen: Observation) -> bool:
    """Return whether the grasper presses on nothing, as its motor tells; before the first cut."""
    return seen.pinch_n < HELD_PINCH_N and not seen.severed.any()


def pulls(seen: Observation) -> bool:
    """Return whether the grasper holds the gallbladder and pulls, as its motors tell."""
    traction_n = np.linalg.norm(seen.forces_n[LEFT_ARM])
    return seen.pinch_n >= HELD_PINCH_N and bool(traction_n >= GRASP_MIN_TRACTION_N)


def holds_too_wide(seen: Observation) -> bool:
    """Return whether tissue is wedged between jaws that are too wide for a grasp."""
    wide = seen.joints[LEFT_ARM, -1] > GRASP_MAX_JAW_RAD
    return seen.pinch_n >= HELD_PINCH_N and bool(wide)


def is_back(seen: Observation) -> bool:
    """Return whether the right tip is seen as far from both tubes as going back asks for."""
    return tip_to_tubes_m(seen) >= RETRACTED_M
