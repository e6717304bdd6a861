"""Tests of centring: jaws close on a tube at its place along it, and nothing else moves."""

import numpy as np
import pytest

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import MOVE
from controller.diffusion.rules.centring import MOST_M, SOONEST, centre_on_place
from controller.diffusion.scene.task_place import ABOVE_LOWEST_M, BESIDE_M, WITHIN_M
from planner.procedure.cholecystectomy import task_from_text
from tests.controller.diffusion.on_tube import RULE_M, seen
from tests.controller.diffusion.rules.ruled import STEPS, apply, still
from tests.tissue_sim.kinds import SLIM_APPLIER
from tissue_sim.frames import Array
from tissue_sim.outcome.clip_rule import cut_room_m
from tissue_sim.sensing.observation import fields
from tissue_sim.tools.arms import RIGHT_ARM

FIRST, THIRD = "clipping first clip left tube", "clipping third clip left tube"
CUT = "go to the cutting position left tube"


def chunk(up_m: float = 0.0, closes: int = STEPS) -> Array:
    """Return a chunk in which the right arm moves up steadily, and closes its jaws at a row."""
    arms = still()
    arms[:, RIGHT_ARM, MOVE.start + 1] = np.linspace(0.0, up_m, STEPS)
    arms[..., -1] = np.where(np.arange(STEPS) < closes, 0.3, 0.0)[:, None]
    return arms.reshape(STEPS, ACTION_SIZE)


def end_m(rows: Array) -> float:
    """Return how far up the right arm is at the end of a chunk."""
    return float(rows.reshape(STEPS, 2, -1)[-1, RIGHT_ARM, MOVE.start + 1])


@pytest.mark.parametrize("off_m", [-8e-4, 8e-4])
@pytest.mark.parametrize("up_m", [0.0, 0.004])
def test_a_chunk_ends_at_the_place_wherever_it_begins(off_m: float, up_m: float) -> None:
    rows = apply(
        centre_on_place, chunk(up_m), seen(RULE_M[0] + off_m - up_m), task_from_text(FIRST)
    )
    assert abs(end_m(rows) + off_m - up_m) <= WITHIN_M + 1e-7


@pytest.mark.parametrize("closes", [SOONEST - 1, SOONEST + 2])
def test_a_chunk_closes_at_the_place_wherever_it_goes_back_to(closes: int) -> None:
    asked = chunk(0.004, closes)
    at_m = 0.004 * closes / (STEPS - 1)
    rows = apply(centre_on_place, asked, seen(RULE_M[0] + 8e-4 - at_m), task_from_text(FIRST))
    up_m = rows.reshape(STEPS, 2, -1)[:, RIGHT_ARM, MOVE.start + 1]
    assert abs(up_m[closes] + 8e-4 - at_m) <= WITHIN_M + 1e-7
    assert end_m(rows) == pytest.approx(end_m(asked) + up_m[closes] - at_m)


def test_jaws_that_have_closed_are_not_moved_suddenly() -> None:
    rows = apply(centre_on_place, chunk(closes=0), seen(RULE_M[0] + 0.005), task_from_text(FIRST))
    up_m = rows.reshape(STEPS, 2, -1)[:, RIGHT_ARM, MOVE.start + 1]
    assert np.abs(np.diff(up_m, prepend=0.0)).max() <= MOST_M / SOONEST + 1e-9


def test_only_the_right_arm_moves_along_the_tube_little_by_little() -> None:
    asked = chunk(0.001)
    changed = (
        apply(centre_on_place, asked, seen(RULE_M[0] + 0.005), task_from_text(FIRST)) - asked
    ).reshape(STEPS, 2, -1)
    moved_m = changed[:, RIGHT_ARM, MOVE.start + 1].copy()
    np.testing.assert_allclose(moved_m, -MOST_M * np.arange(1, STEPS + 1) / STEPS, atol=1e-9)
    changed[:, RIGHT_ARM, MOVE.start + 1] = 0.0
    np.testing.assert_allclose(changed, 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("above_m", "moved_m"), [(0.0, ABOVE_LOWEST_M), (8e-4, 0.0), (0.0045, None)]
)
def test_an_upper_clip_may_go_lower_as_far_as_the_cut_has_room(
    above_m: float, moved_m: float | None
) -> None:
    low_m = RULE_M[1] - 0.001
    lowest_m = low_m + cut_room_m(SLIM_APPLIER)
    rows = apply(
        centre_on_place, chunk(), seen(lowest_m + above_m, 0.004, low_m), task_from_text(THIRD)
    )
    highest_m = max(RULE_M[2], lowest_m) + WITHIN_M - (lowest_m + above_m)
    assert end_m(rows) == pytest.approx(highest_m if moved_m is None else moved_m, abs=1e-6)


def test_the_cut_is_made_in_the_middle_of_its_gap() -> None:
    clips_m = 0.005, 0.009, 0.015
    rows = apply(
        centre_on_place, chunk(), seen(0.0125, *clips_m, scissors=True), task_from_text(CUT)
    )
    assert end_m(rows) == pytest.approx(0.012 + WITHIN_M - 0.0125, abs=1e-6)


def test_a_chunk_elsewhere_is_the_policys() -> None:
    """On the way, going back, without a clip and with the tube cut, nothing is changed."""
    off_m, first = RULE_M[0] + 0.001, task_from_text(FIRST)
    empty, cut = seen(off_m), seen(off_m, 0.005, 0.009, 0.015, scissors=True)
    fields(empty)["clip_loaded"][:] = 0.0
    fields(cut)["severed"][0] = 1.0
    for vector, task in (
        (seen(off_m, beside_m=BESIDE_M + 0.001), first),
        (seen(off_m), task_from_text("going back first clip left tube")),
        (seen(off_m), task_from_text("grabbing gallbladder")),
        (empty, first),
        (cut, task_from_text(CUT)),
    ):
        np.testing.assert_array_equal(apply(centre_on_place, chunk(), vector, task), chunk())
