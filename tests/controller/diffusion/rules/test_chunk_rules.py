"""Tests of all rules together: each changes chunks, in the grab and on a tube, and is counted."""

import numpy as np
from numpy.typing import NDArray

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW, MOVE, TURN
from controller.diffusion.rules.chunk_rules import RULES, ChunkRules
from controller.diffusion.scene.scene import Scene
from planner.procedure.cholecystectomy import GRAB, task_from_text
from planner.procedure.task import Task
from planner.rules.rule_use import ANY
from scenarios.catalogue import CHUNK_RULES
from tests.controller.diffusion.on_tube import RULE_M, seen
from tests.controller.diffusion.rules.ruled import STEPS, still
from tissue_sim.frames import Array, axis_angle
from tissue_sim.sensing.observation import fields
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

WIDE_RAD, NARROW_RAD = 0.35, 0.12
CLIP, BACK = (
    task_from_text(f"{words} first clip left tube") for words in ("clipping", "going back")
)


def chunk(left_rad: float = 0.7, right_rad: float = WIDE_RAD, ahead_m: float = 0.0) -> Array:
    """Return a chunk (16, 2, 10) whose jaws stay as they are, and whose right arm goes ahead."""
    arms = still()
    arms[:, LEFT_ARM, JAW], arms[:, RIGHT_ARM, JAW] = left_rad, right_rad
    arms[:, RIGHT_ARM, MOVE.stop - 1] = np.linspace(0.0, ahead_m, STEPS)
    return arms


def changed(asked: Array, vector: NDArray[np.float32], task: Task, *right_rad: float) -> Array:
    """Return what the rules add to the last row (2, 10) of a chunk."""
    jaws_rad = np.stack([np.full(len(right_rad), 0.7), right_rad], axis=1)
    rules = ChunkRules()
    kept = rules.apply(asked.reshape(STEPS, ACTION_SIZE), Scene(vector), task, jaws_rad)
    return kept.reshape(STEPS, 2, -1)[-1] - asked[-1]


def test_jaws_on_a_tube_reach_their_place_along_it_and_close() -> None:
    low, before, begun = seen(RULE_M[0] - 8e-4), seen(RULE_M[0]), seen(RULE_M[0])
    fields(before)["tips_endoscope"][RIGHT_ARM, 2, 3] -= 0.005
    for vector, jaw_rad in ((low, WIDE_RAD), (before, WIDE_RAD), (begun, NARROW_RAD)):
        fields(vector)["joints"][RIGHT_ARM, -1] = jaw_rad
    held, closing = (WIDE_RAD, WIDE_RAD), (NARROW_RAD + 0.03, NARROW_RAD)
    assert changed(chunk(), low, CLIP, *held)[RIGHT_ARM, MOVE.start + 1] > 5e-4
    assert changed(chunk(ahead_m=-0.002), before, CLIP, *held)[RIGHT_ARM, MOVE.stop - 1] > 0.002
    assert changed(chunk(right_rad=NARROW_RAD), begun, CLIP, *closing)[RIGHT_ARM, JAW] < -0.05
    assert not changed(chunk(ahead_m=-0.002), before, BACK, *held).any()


def test_a_grasper_holds_firmly_and_square_to_a_wide_gallbladder() -> None:
    wedged, wide = seen(RULE_M[0]), seen(RULE_M[0])
    now = fields(wedged)
    now["pinch_n"][:], now["joints"][LEFT_ARM, -1] = 1.0, 0.7
    now = fields(wide)
    now["sac_m"][:] = np.linspace([-0.01, 0.0, 0.09], [0.0, 0.0, 0.09], len(now["sac_m"]))
    now["sac_radius_m"][:], now["joints"][LEFT_ARM, -1] = 0.009, 1.0
    now["tips_endoscope"][LEFT_ARM, :, :3] = axis_angle(np.array([0.0, 1.0, 0.0]), 0.3)
    now["tips_endoscope"][LEFT_ARM, :, 3] = 0.0, 0.0, 0.1
    assert changed(chunk(), wedged, GRAB, WIDE_RAD)[LEFT_ARM, JAW] < -0.02
    assert np.abs(changed(chunk(), wide, GRAB, WIDE_RAD)[LEFT_ARM, TURN]).max() > 0.2
    assert not changed(chunk(), wedged, BACK, WIDE_RAD).any()


def test_the_other_arm_waits_as_the_grasper_grabs() -> None:
    added = changed(chunk(ahead_m=0.002), seen(RULE_M[0]), GRAB, WIDE_RAD)[RIGHT_ARM, MOVE]
    np.testing.assert_allclose(added, [0.0, 0.0, -0.002], atol=1e-9)


def test_what_rules_change_is_counted() -> None:
    rules, low = ChunkRules(), seen(RULE_M[0] - 8e-4)
    fields(low)["joints"][RIGHT_ARM, -1] = WIDE_RAD
    asked, commanded = chunk().reshape(STEPS, ACTION_SIZE), np.array([[0.7, WIDE_RAD]])
    rules.apply(asked, Scene(low), CLIP, commanded)
    rules.apply(asked, Scene(low, is_corrected=True), CLIP, commanded)
    uses = {use.rule: use for use in rules.uses()}
    centred = uses["centre-on-place"]
    assert (centred.decisions, centred.changed, centred.share) == (1, 1, 1.0)
    assert centred.most_m is not None
    assert 5e-4 < centred.most_m < 1e-3
    assert {name: use.decisions for name, use in uses.items()} == {
        name: 2 if name in ("hold-still", "unhook-grasper", ANY) else 1 for name in (*RULES, ANY)
    }
    assert [name for name, use in uses.items() if use.changed] == ["centre-on-place", ANY]


def test_a_rule_that_is_left_out_changes_nothing_and_the_others_act() -> None:
    asked, low = chunk().reshape(STEPS, ACTION_SIZE), seen(RULE_M[0] - 8e-4)
    fields(low)["joints"][RIGHT_ARM, -1] = WIDE_RAD
    commanded = np.array([[0.7, WIDE_RAD]])
    rules = ChunkRules(without=["centre-on-place"])
    np.testing.assert_array_equal(rules.apply(asked, Scene(low), CLIP, commanded), asked)
    names = [use.rule for use in rules.uses()]
    assert names == [*(name for name in RULES if name != "centre-on-place"), ANY]
    assert tuple(RULES) == CHUNK_RULES
    assert ChunkRules(without=RULES).uses() == ()
