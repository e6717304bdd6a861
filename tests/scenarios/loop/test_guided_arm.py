"""Tests of a guided arm: it reaches the person's goal, and the other arm is not changed."""

from itertools import islice

import numpy as np
import pytest

from controller.action import ToolAction
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.guided_arm import REACH_M, GuidedArm
from scenarios.loop.person.inbox import Inbox
from scenarios.run_episode import begin
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM


def led(arm, config=None, n=90):
    """Return an episode in which a person guides an arm 8 mm to the left and 6 mm nearer."""
    inbox = Inbox()
    episode = begin(
        config
        or EpisodeConfig(planner="scripted", scenario="textbook", seed=10_005, controller="idle"),
        inbox=inbox,
    )
    goal = episode.world.arms.T_world_tool()[arm]
    goal[:3, 3] += episode.world.T_world_endoscope[:3, :3] @ [0.008, 0.0, -0.006]
    inbox.guided = GuidedArm(arm=arm, T_world_goal=goal, jaw_rad=0.6)
    return list(islice(episode.steps(), n)), episode, goal


@pytest.mark.parametrize("arm", [LEFT_ARM, RIGHT_ARM])
def test_the_arm_comes_to_the_goal_and_the_other_one_stays(arm):
    steps, episode, goal = led(arm)
    start = steps[0].observation.tips_endoscope
    assert np.linalg.norm(episode.world.arms.T_world_tool()[arm, :3, 3] - goal[:3, 3]) < 5e-4
    assert episode.world.target[arm, 6] == pytest.approx(0.6, abs=1e-6)
    moved = np.linalg.norm(steps[-1].observation.tips_endoscope - start, axis=(1, 2))
    assert moved[1 - arm] < 2e-4 < moved[arm]


def test_the_other_arms_action_passes_unchanged():
    _, episode, goal = led(LEFT_ARM, n=1)
    rng = np.random.default_rng(0)
    action = ToolAction(
        move_endoscope_m=rng.normal(size=(2, 3)),
        turn_tool=rng.normal(size=(2, 6)),
        jaw_rad=rng.normal(size=2),
    )
    guided = GuidedArm(arm=LEFT_ARM, T_world_goal=goal, jaw_rad=0.1)
    changed = guided.lead(action, episode.world).vector().reshape(2, 10)
    np.testing.assert_array_equal(changed[RIGHT_ARM], action.vector().reshape(2, 10)[RIGHT_ARM])
    assert not np.array_equal(changed[LEFT_ARM], action.vector().reshape(2, 10)[LEFT_ARM])


def test_each_step_says_who_led():
    steps, episode, _ = led(RIGHT_ARM, n=5)
    assert all(step.guided is episode.inbox.guided for step in steps)
    assert all(step.disturbed for step in steps)
    episode.inbox.guided = None
    assert all(step.guided is None for step in islice(episode.steps(), 5))


def test_a_goal_in_the_liver_is_not_reached_but_the_gallbladder_on_the_way_is_pierced():
    """Check that the filter keeps a tool from the liver; it does not know the gallbladder."""
    inbox = Inbox()
    episode = begin(
        EpisodeConfig(planner="scripted", scenario="textbook", seed=10_005, controller="idle"),
        inbox=inbox,
    )
    goal = episode.world.arms.T_world_tool()[RIGHT_ARM]
    bed = episode.world.organ.bed
    goal[:3, 3] = bed.point_m - 0.01 * bed.normal + 0.05 * bed.along
    inbox.guided = GuidedArm(arm=RIGHT_ARM, T_world_goal=goal, jaw_rad=0.0)
    steps = list(islice(episode.steps(), 300))
    assert np.linalg.norm(episode.world.arms.T_world_tool()[RIGHT_ARM, :3, 3] - goal[:3, 3]) > 2e-3
    assert any("liver" in limit for step in steps for e in step.altered for limit in e.limits)
    hurt = {injury.event for injury in episode.world.record.injuries}
    assert hurt == {"perforation of gallbladder", "leak"}


HERE = np.eye(4)
MIRRORED = np.diag([1.0, 1.0, -1.0, 1.0])
FAR = HERE.copy()
FAR[0, 3] = 1.1 * REACH_M


@pytest.mark.parametrize(
    ("arm", "T", "jaw_rad"),
    [
        (2, HERE, 0.0),
        (LEFT_ARM, np.full((4, 4), np.nan), 0.0),
        (LEFT_ARM, np.zeros((4, 4)), 0.0),
        (LEFT_ARM, 2.0 * HERE, 0.0),
        (LEFT_ARM, MIRRORED, 0.0),
        (LEFT_ARM, HERE[:3], 0.0),
        (LEFT_ARM, FAR, 0.0),
        (LEFT_ARM, HERE, np.nan),
        (LEFT_ARM, HERE, 1e9),
    ],
)
def test_what_is_no_goal_is_refused(arm, T, jaw_rad):
    with pytest.raises(ValueError, match=r"no pose|out of reach"):
        GuidedArm(arm=arm, T_world_goal=T, jaw_rad=jaw_rad)
