"""Tests of a lost clip: the expert draws the empty applier back to get a new clip."""

import numpy as np

from controller.expert.controller import ControllerExpert
from planner.instruction import TASKS, Instruction
from tests.worlds import textbook_world
from tissue_sim.tools.arms import RIGHT_ARM, JointCommand

CLIP = TASKS[1]


def advance_m(expert, world):
    """Return how far (m) the next chunk moves the applier forward along its own axis."""
    chunk = expert.act(world.observe(), Instruction(task=CLIP))
    moved = sum(action.move_endoscope_m[RIGHT_ARM] for action in chunk)
    forward = world.arms.T_world_tool()[RIGHT_ARM, :3, 2]
    return float(world.T_world_endoscope[:3, :3] @ moved @ forward)


def test_it_goes_forward_with_a_clip_and_back_once_the_clip_is_lost():
    world = textbook_world(10_001)
    expert = ControllerExpert(world)
    assert advance_m(expert, world) > 0
    world.drop_clip()
    assert advance_m(expert, world) == 0  # the jaws open first
    for _ in range(int(np.ceil(1.2 * 30))):
        world.step(JointCommand(joints=world.target))
    assert advance_m(expert, world) < 0
    world.equip("clip_applier")
    ways_m = [advance_m(expert, world) for _ in range(3)]  # the grasper may make room first
    assert min(ways_m) >= 0
    assert ways_m[-1] > 0
