"""Tests of the expert: asked to grab what it holds, it goes on, and lets go of nothing."""

from itertools import islice

import pytest

from controller.expert.controller import ControllerExpert
from planner.instruction import TASKS
from scenarios.demonstration.demonstrate import begun
from scenarios.demonstration.mix import PlannedDemonstration
from tissue_sim.outcome.predicates import gallbladder_grasped, gallbladder_held

SEED = 10_001  # operable
GRAB = TASKS[0]
MOST_STEPS = 300


@pytest.mark.parametrize("steps_held", [1, 15])
def test_taking_over_a_held_gallbladder_it_does_not_let_go(steps_held: int) -> None:
    episode = begun(PlannedDemonstration(seed=SEED, kind="nominal", noise=False))
    world, steps = episode.world, episode.steps()
    next(step for step in steps if gallbladder_held(world))
    list(islice(steps, steps_held))
    episode.controller = ControllerExpert(world)  # as in turns: it knows nothing of before
    while not gallbladder_grasped(world):
        step = next(islice(steps, MOST_STEPS))
        assert step.instruction.task == GRAB
        assert gallbladder_held(world)
