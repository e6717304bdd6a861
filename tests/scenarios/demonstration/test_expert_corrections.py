"""Tests of the expert: it obeys each of the 18 corrections, in the open and at work, safely."""

from itertools import islice

import numpy as np
import pytest

from controller.expert.controller import ControllerExpert
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE
from planner.instruction import Instruction
from planner.procedure.cholecystectomy import TASKS
from scenarios.bench.trials.obedience_trial import PlannerFixed
from scenarios.catalogue import ORACLE
from scenarios.demonstration.interjections import is_harmless
from scenarios.episode import Episode
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tissue_sim.sensing.exact import SenseExact

CONFIG = EpisodeConfig(**ORACLE, scenario="textbook", seed=10_001)
WITHIN_STEPS = 60  # 2 s
MIN_M, MIN_RAD = 3e-3, 0.2
ASIDE = 0.5  # share of the motion: tissue yields, and the filter slides along obstacles
ASTRIDE_M = 0.006  # largest distance of the tip from a tube's middle line
HARMFUL = {  # the grasper would crush tissue, and the applier would clip too early
    TASKS[0]: (),
    TASKS[1]: [c for c in CORRECTIONS if c.jaw == "close"],
}
NAMES = {TASKS[0]: "in the open", TASKS[1]: "at work"}
HARMLESS = [(task, c) for task, harm in HARMFUL.items() for c in CORRECTIONS if c not in harm]
ROWS = {"left": [0], "right": [1], "both": [0, 1]}


@pytest.fixture(scope="module")
def scenes(made_once):
    """Return a world and two states: before the grasp, and with the open applier around a tube."""
    world = begin(CONFIG).world
    return world, made_once("scenes", lambda _: {task: state_in(task) for task in HARMFUL})


def state_in(task):
    """Return the state of the world in the middle of a task."""
    episode = begin(CONFIG)
    for step in episode.steps():
        far = step.time_s > 1.5 if task == TASKS[0] else is_astride(episode.world)
        if step.instruction.task == task and far:
            return episode.world.state()
    raise AssertionError(f"the episode never came to {task.text}")


def is_astride(world):
    tip = world.arms.T_world_tool()[1, :3, 3]
    centres = np.concatenate([world.tubes.centres(tube) for tube in world.organ.tubes])
    return np.linalg.norm(centres - tip, axis=1).min() < ASTRIDE_M


def begun_again(scenes, task, correction):
    world, states = scenes
    world.restore(states[task])
    episode = Episode(
        config=CONFIG,
        world=world,
        planner=PlannerFixed(instruction=Instruction(task=task, correction=correction)),
        controller=ControllerExpert(world),
        sense=SenseExact(),
        observation=world.observe(),
    )
    episode.guarded_driver.driver.follow(world.target)
    return episode


@pytest.mark.parametrize("task", HARMFUL, ids=NAMES.get)
def test_a_harmful_correction_is_not_demonstrated(scenes, task):
    world, states = scenes
    world.restore(states[task])
    assert [c for c in CORRECTIONS if not is_harmless(c, world)] == list(HARMFUL[task])


@pytest.mark.parametrize(
    ("task", "correction"), HARMLESS, ids=[f"{NAMES[task]}: {c.text}" for task, c in HARMLESS]
)
def test_the_named_arm_moves_as_named_within_two_seconds_and_the_other_stays(
    scenes, task, correction
):
    episode = begun_again(scenes, task, correction)
    start, rows = episode.observation, ROWS[correction.arm]
    for step in islice(episode.steps(), WITHIN_STEPS):
        moved_m = (step.observation.tips_endoscope - start.tips_endoscope)[:, :3, 3]
        opened_rad = step.observation.joints[:, 6] - start.joints[:, 6]
        if is_obeyed(correction, moved_m[rows], opened_rad[rows]):
            break
    else:
        pytest.fail(f"moved by {moved_m} m, jaws by {opened_rad} rad")
    others = [arm for arm in (0, 1) if arm not in rows or correction.jaw]
    assert np.linalg.norm(moved_m[others], axis=1).max(initial=0.0) < MIN_M
    assert episode.world.record.injuries == ()


def is_obeyed(correction, moved_m, opened_rad):
    if correction.direction is None:
        sign = 1.0 if correction.jaw == "open" else -1.0
        return (sign * opened_rad >= MIN_RAD).all()
    along = np.array(DIRECTION_ENDOSCOPE[correction.direction])
    far_m = moved_m @ along
    aside_m = np.linalg.norm(moved_m - far_m[:, None] * along, axis=1)
    return (far_m >= MIN_M).all() and (aside_m < ASIDE * far_m).all()
