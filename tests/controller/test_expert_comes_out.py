"""Tests of the expert: it takes the grasper gently out of a fold, and the right tool straight."""

from itertools import islice

import numpy as np
import pytest

from controller.expert.approach import STANDOFF_M
from controller.expert.skills import INSERTION, _further_back, among_tissue
from controller.kinematics import inverse_kinematics
from planner.command import COMMANDS
from planner.instruction import TASKS
from scenarios.demonstration.demonstrate import begun
from scenarios.demonstration.mix import PlannedDemonstration
from tests.worlds import textbook_world
from tissue_sim.frames import inverse_pose
from tissue_sim.outcome.predicates import gallbladder_held
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM, JointCommand
from tissue_sim.tools.psm import joint_limits

SEED = 10_003
GRAB = TASKS[0]
MAX_N = 1.5  # when the jaws opened wide inside the fold, it was 3.9 N and they stayed inside
WORDS_LAST, ACTS_BY, OUT_BY = 15, 30, 240  # steps; the words' motion is still in force


@pytest.mark.parametrize("said", ["open left gripper", "move left arm towards me"])
def test_after_a_slip_and_a_command_the_grasper_comes_free(said):
    episode = begun(PlannedDemonstration(seed=SEED, kind="recovery:grasp-slip", noise=False))
    world, steps = episode.world, episode.steps()
    next(step for step in steps if gallbladder_held(world))
    next(step for step in steps if not gallbladder_held(world))
    episode.inbox.press(COMMANDS[said])
    list(islice(steps, WORDS_LAST))
    assert among_tissue(LEFT_ARM, world)
    episode.inbox.press(COMMANDS[GRAB.text])
    pulled_n = []
    for step in islice(steps, OUT_BY):
        pulled_n.append(np.linalg.norm(step.observation.forces_n[LEFT_ARM]))
        if not among_tissue(LEFT_ARM, world):
            break
    assert not among_tissue(LEFT_ARM, world)
    assert max(pulled_n[ACTS_BY:]) < MAX_N


def test_a_retraction_moves_the_insertion_alone_so_that_a_wrist_at_its_limit_follows():
    world = textbook_world(10_000)
    joints = world.target.copy()
    joints[RIGHT_ARM, 3:6] = joint_limits(world.arms.mounted[RIGHT_ARM])[3:6, 1] - 1e-6
    world.step(JointCommand(joints=joints))
    goal = _further_back(world, world.arms.T_world_tool()[RIGHT_ARM]).T_world_tool
    T_rcm_goal = inverse_pose(world.arms.T_world_rcm[RIGHT_ARM]) @ goal
    start = world.target[RIGHT_ARM, :6]
    reached = inverse_kinematics(T_rcm_goal, world.arms.mounted[RIGHT_ARM], start)
    expected = start.copy()
    expected[INSERTION] -= STANDOFF_M
    np.testing.assert_allclose(reached, expected, atol=1e-6)
