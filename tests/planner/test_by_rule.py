"""Tests of the planner by rule: it leads through the procedure by what is seen alone."""

from typing import Any

import numpy as np
import pytest

from planner.ablations import PlannerByRule
from planner.instruction import Instruction
from planner.procedure.cholecystectomy import GRAB, TASKS
from planner.rules.task_gate import GRASPED_S
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import run_episode
from tests.planner.observations import at_work, writable
from tissue_sim.patient.tube_names import USUAL_TUBES


class Listener:
    """Notes which tasks were given, in their order."""

    def __init__(self) -> None:
        self.given: list[Instruction] = []

    def on_reset(self, world: Any) -> None:
        del world

    def on_step(self, step: Any) -> None:
        if not self.given or self.given[-1].task != step.instruction.task:
            self.given.append(step.instruction)

    def on_end(self, result: Any) -> None:
        del result


def at_first_clip() -> PlannerByRule:
    """Return a planner that has left the grab, which is seen to be good, for the first clip."""
    planner = PlannerByRule()
    for time_s in np.arange(0.0, GRASPED_S + 1.5):
        grasped = writable(at_work(time_s=float(time_s)))
        grasped.forces_n[0, 1] = 1.0
        said = planner.plan(grasped)
    assert said.task == TASKS[1]
    return planner


def test_it_begins_with_the_grab():
    assert PlannerByRule().plan(at_work()).task == GRAB


def test_a_clip_that_is_seen_is_followed_by_the_way_back_and_the_next():
    planner = at_first_clip()
    assert planner.plan(at_work(1, time_s=4.0)).task == TASKS[2]
    assert planner.plan(at_work(1, time_s=5.0, back=True)).task == TASKS[3]


def test_a_gallbladder_that_slipped_is_grabbed_again_once_the_arm_is_back():
    planner = at_first_clip()
    assert planner.plan(at_work(time_s=4.0, held=False)).task == TASKS[1]
    assert planner.plan(at_work(time_s=5.0, held=False)).task == TASKS[2]
    assert planner.plan(at_work(time_s=6.0, back=True, held=False)).task == GRAB


@pytest.mark.slow
def test_an_expert_that_it_leads_passes():
    listener = Listener()
    config = EpisodeConfig(
        planner="rule", controller="expert", sense="exact", scenario="textbook", seed=10_004
    )
    assert run_episode(config, [listener]).success
    tubes = (None, *USUAL_TUBES)  # a textbook patient has no third tube
    assert [said.task for said in listener.given] == [t for t in TASKS if t.tube in tubes]
    assert all(said.correction is None for said in listener.given)
