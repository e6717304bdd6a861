"""Tests of the scrub nurse: the right arm is drawn back, gets its tool outside, and returns."""

import numpy as np
import pytest

from tissue_sim.outcome import nurse
from tissue_sim.outcome.nurse import EXCHANGE_S, JAW, OUT_INSERTION_M
from tissue_sim.tools.arms import HOME_JOINTS, LEFT_ARM, RIGHT_ARM
from tissue_sim.world import World

INSERTION = 2
SEED = 5


def joints_at(insertion_m: float) -> np.ndarray:
    joints = np.tile(HOME_JOINTS, (2, 1))
    joints[RIGHT_ARM, INSERTION] = insertion_m
    joints[RIGHT_ARM, [0, 1, 3, 4, 5]] = 0.1, -0.05, 0.3, 0.2, -0.1
    return joints


def exchanged(world: World, tool: str, joints: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Return the commanded joints (n, 2, 7) and the mounted tool at each of them."""
    path, tools = [], []
    for command in nurse.exchange(world, tool, joints):
        path.append(command.joints)
        tools.append(world.arms.mounted[RIGHT_ARM].name)
    return np.stack(path), tools


@pytest.mark.parametrize("insertion_m", [0.03, 0.05, 0.09])
def test_the_tool_goes_out_and_the_new_one_comes_in_to_the_home_pose(
    world: World, insertion_m: float
) -> None:
    """Check also a start that is farther out than the exchange needs."""
    start = joints_at(insertion_m)
    path, tools = exchanged(world, "scissors", start)
    assert len(path) == 2 * round(EXCHANGE_S / world.config.control_step_s)
    depth_m = path[:, RIGHT_ARM, INSERTION]
    change = tools.index("scissors")
    assert (np.diff(depth_m[:change]) <= 1e-12).all()
    assert (np.diff(depth_m[change:]) >= -1e-12).all()
    assert depth_m[change - 1] == pytest.approx(min(OUT_INSERTION_M, insertion_m))
    np.testing.assert_allclose(path[-1, RIGHT_ARM], HOME_JOINTS, atol=1e-12)
    np.testing.assert_allclose(path[-1, LEFT_ARM], start[LEFT_ARM], atol=1e-12)


def test_the_right_arm_straightens_and_nothing_else_moves(world: World) -> None:
    start = joints_at(0.09)
    path, tools = exchanged(world, "scissors", start)
    outside = path[tools.index("scissors"), RIGHT_ARM]
    np.testing.assert_allclose(np.delete(outside, [INSERTION, JAW]), np.zeros(5), atol=0.01)
    still = np.ones((2, 7), bool)
    still[RIGHT_ARM, :JAW] = False
    np.testing.assert_allclose(path[:, still], np.tile(start[still], (len(path), 1)), atol=1e-12)


def test_it_starts_and_stops_gently(world: World) -> None:
    """Check that the first and the last step of each way are far shorter than the longest one."""
    path, tools = exchanged(world, "scissors", joints_at(0.09))
    change = tools.index("scissors")
    for way in (np.vstack([joints_at(0.09)[None], path[:change]]), path[change - 1 :]):
        steps_m = np.abs(np.diff(way[:, RIGHT_ARM, INSERTION]))
        assert max(steps_m[0], steps_m[-1]) < 0.2 * steps_m.max()


def test_the_nurse_is_needed_for_another_tool_or_a_missing_clip_only(world: World) -> None:
    assert not nurse.is_needed(world.observe(), "clip_applier", clip=True)
    assert nurse.is_needed(world.observe(), "scissors", clip=False)
    world.drop_clip()
    assert nurse.is_needed(world.observe(), "clip_applier", clip=True)
    assert not nurse.is_needed(world.observe(), "clip_applier", clip=False)
    exchanged(world, "clip_applier", joints_at(0.09))
    assert world.record.clip_loaded
    assert not nurse.is_needed(world.observe(), "clip_applier", clip=True)
    assert world.arms.mounted[LEFT_ARM].name == "grasper"
