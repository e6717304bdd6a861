"""Situations for the safety filter's limits, put together by hand; no simulator."""

import numpy as np

from controller.safety.arm_motion import arm_motion
from controller.safety.bounds import N_MOTION
from controller.safety.exemption import WorkedOn
from controller.safety.geometry.collision import ACTIVATION_M, NO_LINK, NearPairs
from controller.safety.geometry.link_cores import N_LINK, link_cores
from controller.safety.situation import Situation
from planner.instruction import TASKS, Instruction
from tests.controller.safety.field import HOME, T_WORLD_RCM, TOOLS
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.tools.instruments import PATCH_LINKS

GRAB = Instruction(task=TASKS[0])


def pairs(*rows):
    """Return near pairs; each row is (distance_m, arm, link, obstacle)."""
    distance, arm, link, obstacle = zip(*rows, strict=True) if rows else ((), (), (), ())
    n = len(rows)
    return NearPairs(
        distance_m=np.array(distance, float),
        on_instrument_m=np.zeros((n, 3)),
        on_obstacle_m=np.zeros((n, 3)),
        normal=np.tile([0.0, 0.0, 1.0], (n, 1)),
        arm=np.array(arm, np.int32),
        link=np.array([PATCH_LINKS.index(name) for name in link], np.int32),
        other_link=np.full(n, NO_LINK, np.int32),
        names=obstacle,
        what=np.arange(n),
        foremost=np.ones(n, bool),
        capsule=np.zeros(n, np.int32),
        within_m=ACTIVATION_M,
        others_m=np.full((N_LINK, N_LINK), ACTIVATION_M),
        links=link_cores(HOME, TOOLS, T_WORLD_RCM),
    )


NOTHING: WorkedOn = (frozenset(), frozenset())
DUCT: WorkedOn = (frozenset(), frozenset({"duct"}))  # the right jaws work on it


def situation(asked=HOME, start=HOME, near=(), **changes):
    """Return a situation at rest at home, nothing near, no force, except for the `changes`."""
    near = pairs(*near)
    usual = {
        "step_s": CONTROL_PERIOD_S,
        "instruments": TOOLS,
        "start": start,
        "rate": np.zeros((2, 7)),
        "asked": asked,
        "near": near,
        "parting": np.eye(N_MOTION)[: len(near.arm)],  # each pair has its own joint
        "coming_m_s": np.zeros(len(near.arm)),
        "tool_force_n": np.zeros((2, 3)),
        "pinch_n": 0.0,
        "shaft_offset_m": np.zeros(2),
        "instruction": GRAB,
        "worked_on": NOTHING,
        "between_jaws": frozenset(),
        "lacking_clips": frozenset(),
        "crowded": frozenset(),
        "partly": frozenset(),
    }
    given = usual | changes
    motion = (asked - start).ravel()
    arms = arm_motion(start, motion, given["instruments"], T_WORLD_RCM)
    return Situation(**given, arms=arms)


def keeps(bounds, motion):
    """Return whether a motion (14,) breaks no row."""
    return (bounds.excess(motion) <= 1e-12).all()
