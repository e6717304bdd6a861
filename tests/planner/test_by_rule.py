"""Tests of the planner by rule: it leads through the procedure by what is seen alone."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from planner.by_rule import PlannerByRule
from planner.instruction import Instruction
from planner.seen.due import GRASPED_S
from planner.task import GRAB, TASKS
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import run_episode
from tests.planner.seen import clipped
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import HELD_PINCH_N, RETRACTED_M


def seen(time_s: float, clips: int = 0, *, held: bool = True) -> Observation:
    """Return an observation with the right tip at the tubes, and the gallbladder held or not."""
    made = clipped(clips, time_s=time_s)
    made.tips_endoscope[1, :3, 3] = made.left_tube_m[3]
    return replace(made, pinch_n=(1.2 if held else 0.4) * HELD_PINCH_N)


def back(observation: Observation) -> Observation:
    tips = observation.tips_endoscope.copy()
    tips[1, 2, 3] -= 1.1 * RETRACTED_M
    return replace(observation, tips_endoscope=tips)


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
        grasped = seen(float(time_s))
        grasped.forces_n[0, 1] = 1.0
        said = planner.plan(grasped)
    assert said.task == TASKS[1]
    return planner


def test_it_begins_with_the_grab():
    assert PlannerByRule().plan(seen(0.0)).task == GRAB


def test_a_clip_that_is_seen_is_followed_by_the_way_back_and_the_next():
    planner = at_first_clip()
    assert planner.plan(seen(4.0, 1)).task == TASKS[2]
    assert planner.plan(back(seen(5.0, 1))).task == TASKS[3]


def test_a_gallbladder_that_slipped_is_grabbed_again_once_the_arm_is_back():
    planner = at_first_clip()
    assert planner.plan(seen(4.0, held=False)).task == TASKS[1]
    assert planner.plan(seen(5.0, held=False)).task == TASKS[2]
    assert planner.plan(back(seen(6.0, held=False))).task == GRAB


@pytest.mark.slow
def test_an_expert_that_it_leads_passes():
    listener = Listener()
    config = EpisodeConfig(
        planner="rule", controller="expert", sense="exact", scenario="textbook", seed=10_004
    )
    assert run_episode(config, [listener]).success
    assert [said.task for said in listener.given] == list(TASKS)
    assert all(said.correction is None for said in listener.given)
