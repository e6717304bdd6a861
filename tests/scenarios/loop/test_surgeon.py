"""Tests of the scripted surgeon: it speaks where jaws would close beside their place, only then."""

from collections.abc import Sequence
from itertools import takewhile
from typing import Any

import numpy as np
import pytest

from controller.expert.targets import belongs_here, clip_pose
from planner.instruction import TASKS
from planner.procedure.outcomes import structure_of
from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.inbox import Inbox
from scenarios.loop.person.surgeon import CONTENT_M, SHOWN_M, WORDS
from scenarios.loop.policies import make_person
from scenarios.loop.step import Step
from scenarios.run_episode import begin
from tests.stand_ins import needs_trained
from tissue_sim.patient.tubes import between_jaws
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.world import World

CLIP = TASKS[1]
LEARNED = {"planner": "learned", "controller": "diffusion", "sense": "tracked"}
SHIFTED = LEARNED | {"scenario": "hand-eye", "magnitude": 0.003, "seed": 10_020}


def until_first_clip(**config: Any) -> tuple[Sequence[Step], World]:
    """Return the steps of an episode, as far as to its first clip, and the world then."""
    inbox, made = Inbox(), EpisodeConfig(**config)
    episode = begin(made, inbox=inbox)
    people = make_person(made, inbox)
    for person in people:
        person.on_reset(episode.world)
    steps = list[Step]()
    for step in takewhile(lambda _: not episode.world.record.clips, episode.steps()):
        steps.append(step)
        for person in people:
            person.on_step(step)
    return steps, episode.world


def words(steps: Sequence[Step]) -> list[str]:
    return [heard.text for step in steps for heard in step.heard]


@pytest.fixture(scope="module")
def corrected():
    return until_first_clip(**SHIFTED, person="surgeon")


def test_it_says_nothing_where_jaws_close_rightly():
    steps, world = until_first_clip(**ORACLE, scenario="textbook", seed=10_004, person="surgeon")
    assert world.record.clips
    assert steps[-1].instruction.task == CLIP
    assert not words(steps)


@needs_trained
def test_it_has_jaws_closed_where_they_clip_the_tube_that_is_meant(corrected):
    steps, world = corrected
    tube = structure_of(CLIP, world)
    (clip,) = world.record.clips
    assert [crossing.tube for crossing in clip.crossings] == [tube]
    place = clip_pose(world, tube, 1)
    off_m = place[:3, 3] - world.arms.T_world_tool()[RIGHT_ARM, :3, 3]
    assert abs(off_m @ place[:3, 0]) < SHOWN_M
    assert words(steps)[-1] == WORDS["close"]


@needs_trained
def test_it_says_corrections_with_lengths_that_a_surgeon_can_see(corrected):
    said = [text.partition(" by ") for text in words(corrected[0])]
    moves = [(way, float(size.split()[0])) for way, by, size in said if by]
    assert {way for way, _, _ in said} <= set(WORDS.values())
    assert moves
    assert all(1e3 * CONTENT_M <= size < 10.0 for _, size in moves)


@needs_trained
def test_the_robot_says_and_keeps_what_it_was_shown(corrected):
    steps, _ = corrected
    told = [text for step in steps for text in step.told if "the right tool to be" in text]
    assert told
    before, after = steps[0], steps[-1]
    errors_m = [
        step.observation.tips_endoscope[RIGHT_ARM, :3, 3]
        - step.exact.tips_endoscope[RIGHT_ARM, :3, 3]
        for step in (before, after)
    ]
    assert np.linalg.norm(errors_m[1]) < 0.5 * np.linalg.norm(errors_m[0])


@needs_trained
def test_without_it_the_same_jaws_close_where_a_clip_is_of_no_use():
    _, world = until_first_clip(**SHIFTED)
    tube, T = structure_of(CLIP, world), world.arms.T_world_tool()[RIGHT_ARM]
    on_tube = between_jaws(world.tubes, T, "clip_applier") == {tube}
    place = clip_pose(world, tube, 1)
    low_m = abs((place[:3, 3] - T[:3, 3]) @ place[:3, 0])
    assert not (on_tube and belongs_here(world, tube, T) and low_m < SHOWN_M)
