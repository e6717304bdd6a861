"""Define rules of the procedure that no policy may break; a person may override them explicitly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from controller.safety.bounds import (
    EACH_JOINT,
    JOINTS,
    N_MOTION,
    NO_BOUNDS,
    Bounds,
    Limit,
    at_least,
    between,
)
from controller.safety.geometry.collision import NearPairs
from controller.safety.limits.arms import TIP_SPEED_M_S, tip_box
from controller.safety.situation import Situation
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.tubes import GALLBLADDER
from tissue_sim.tools.arms import RIGHT_ARM

NEAR_AT_RISK_M = 0.008  # assumed
SLOW_M_S = 0.02  # assumed: a surgeon's speed beside structures that must not be injured
_RIGHT_JAW = 13
_JAWS = {"left": 6, "right": _RIGHT_JAW}
_TIP_ROWS = 3  # of each arm in a box


def require_clips_before_cut(situation: Situation) -> Bounds:
    """Keep the scissors from closing on a structure whose needed clips are not observed."""
    bare = sorted(situation.lacking_clips)
    cutting = situation.instruments[RIGHT_ARM].deed == "cut"
    return _no_closing(bare) if cutting and bare else NO_BOUNDS


def close_on_what_is_meant(situation: Situation) -> Bounds:
    """Let scissors and applier close on the structure of the instruction, or on nothing."""
    task = situation.instruction.task
    meant = situation.worked_on[RIGHT_ARM] if task.is_deed else frozenset[str]()
    if task.places_clip and task.clip == USUAL_CLIPS and meant & situation.between_jaws:
        meant |= {GALLBLADDER}  # the highest clip leaves with the gallbladder
    wrong = sorted(situation.between_jaws - meant)
    return _no_closing(wrong) if wrong else NO_BOUNDS


def require_room_beside_clips(situation: Situation) -> Bounds:
    """Let applier and scissors close only where clips beside them leave room for it."""
    crowded = sorted(situation.crowded)
    return _no_closing(crowded) if crowded else NO_BOUNDS


def close_on_whole_tubes(situation: Situation) -> Bounds:
    """Keep the applier from closing on a part of a tube: such a clip comes off."""
    partly = sorted(situation.partly)
    return _no_closing(partly) if partly else NO_BOUNDS


def obey_prohibitions(situation: Situation) -> Bounds:
    """Keep jaws from forbidden acts: to close on a tube, or to open."""
    forbidden = situation.instruction.forbidden
    if not forbidden:
        return NO_BOUNDS
    act = situation.instruments[RIGHT_ARM].deed
    shut = sorted(
        name for name in situation.between_jaws if {act, f"{act} {name}"} & set(forbidden)
    )
    stay = [j for side, j in _JAWS.items() if {"open", f"open {side} gripper"} & set(forbidden)]
    lower, upper = np.full(N_MOTION, -np.inf), np.full(N_MOTION, np.inf)
    lower[[_RIGHT_JAW] if shut else []] = 0.0
    upper[stay] = 0.0
    rows = np.flatnonzero(np.isfinite(lower) | np.isfinite(upper))
    what = [f"{JOINTS[j]} on {', '.join(shut)}" if j not in stay else JOINTS[j] for j in rows]
    return between(EACH_JOINT[rows], lower[rows], upper[rows], what) if len(rows) else NO_BOUNDS


def slow_near_at_risk(situation: Situation) -> Bounds:
    """Slow an arm near the common bile duct or the hepatic artery."""
    near = situation.near
    close = near.of(*AT_RISK) & (near.distance_m < NEAR_AT_RISK_M)
    if not close.any():
        return NO_BOUNDS
    slow = np.bincount(near.arm[close], minlength=2) > 0
    box = tip_box(situation, situation.step_s * np.where(slow, SLOW_M_S, TIP_SPEED_M_S))
    what = [
        f"{tool.in_words} slowed{_near(near, close & (near.arm == arm))}"
        for arm, tool in enumerate(situation.instruments)
    ]
    return replace(box, what=tuple(np.repeat(what, _TIP_ROWS).tolist()))


def _near(near: NearPairs, among: NDArray[np.bool_]) -> str:
    """Return in words the nearest obstacle among some pairs; "" if there are none."""
    rows = np.flatnonzero(among)
    if not len(rows):
        return ""
    return f" near the {near.pair(int(rows[near.distance_m[rows].argmin()]))[2]}"


def _no_closing(because_of: list[str]) -> Bounds:
    what = f"{JOINTS[_RIGHT_JAW]} on {', '.join(because_of)}"
    return at_least(EACH_JOINT[[_RIGHT_JAW]], np.zeros(1), [what])


INTERLOCKS: dict[str, Limit] = {
    "clips before a cut": require_clips_before_cut,
    "only what is meant": close_on_what_is_meant,
    "room beside clips": require_room_beside_clips,
    "whole tubes": close_on_whole_tubes,
    "forbidden by a person": obey_prohibitions,
    "slow near a structure at risk": slow_near_at_risk,
}
JAW_LOCKS = ("clips before a cut", "only what is meant", "room beside clips", "whole tubes")
