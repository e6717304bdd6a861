"""Tests of an episode in which people give instructions, on a real patient."""

from itertools import islice, takewhile

import numpy as np
import pytest

from planner.command import COMMANDS
from planner.instruction import CORRECTIONS, TASKS, Instruction
from planner.person.orders import DEFAULT_M
from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.inbox import Inbox
from scenarios.loop.person.script import Timed
from scenarios.run_episode import begin
from tests.scenarios.loop.saying import Saying
from tests.slow import slow
from tissue_sim.outcome.nurse import EXCHANGE_S
from tissue_sim.outcome.predicates import gallbladder_grasped, gallbladder_held
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

SEED = 10_004
STEP_S = 1 / 30
HIGHER, LEFT = "move right arm higher", "move right arm to the left"


def steps_of(*said, n=180, **config):
    """Return n steps of an episode in which these (time, text) are said, and the episode."""
    inbox = Inbox()
    inbox.arrange([Timed(time_s=time_s, text=text) for time_s, text in said])
    episode = begin(
        EpisodeConfig(**ORACLE | {"scenario": "textbook", "seed": SEED} | config), inbox=inbox
    )
    return list(islice(episode.steps(), n)), episode


@pytest.fixture(scope="module")
def unspoken():
    return steps_of()[0]


def commands(steps):
    return np.stack([step.command.joints for step in steps])


def test_a_persons_correction_is_heard_at_once_and_goes_its_distance(unspoken):
    steps, episode = steps_of((0.5, HIGHER), n=200)
    said = [step for step in steps if step.instruction.source == "human"]
    first, last = steps.index(said[0]), steps.index(said[-1])
    assert steps[first - 1].time_s == pytest.approx(0.5)
    assert len(said) == last - first + 1
    done, stays = steps[last + 1].told
    assert done.startswith(f"Done: {HIGHER} by 4 mm.")
    assert stays.startswith("The right arm stays there for 3 s")
    np.testing.assert_array_equal(commands(steps[:first]), commands(unspoken[:first]))
    assert not np.array_equal(steps[first].command.joints, unspoken[first].command.joints)
    tips = [steps[k].exact.tips_endoscope[RIGHT_ARM, :3, 3] for k in (first - 1, last)]
    assert tips[1][1] - tips[0][1] == pytest.approx(DEFAULT_M, abs=5e-4)
    assert episode.tasks.results[1].corrections == 1
    assert [(k, h.text) for k, s in enumerate(steps) for h in s.heard] == [(first, HIGHER)]


def test_a_correction_at_the_slowest_speed_goes_its_distance_too():
    slower = [(0.3 + 0.1 * k, "slower") for k in range(3)]
    steps, _ = steps_of(*slower, (0.8, "left arm up 8 mm"), n=450)
    done, _ = [told for step in steps for told in step.told]
    assert done.startswith("Done: move left arm higher by 8 mm.")
    said = [step for step in steps if step.instruction.source == "human"]
    assert said[-1].time_s - said[0].time_s > 8.0
    tips = [step.exact.tips_endoscope[LEFT_ARM, :3, 3] for step in (said[0], said[-1])]
    assert tips[1][1] - tips[0][1] == pytest.approx(0.008, abs=5e-4)


@pytest.mark.parametrize("text", ["the weather is nice", "", "\x00\x07", "cut left tube"])
def test_a_text_not_understood_or_not_due_moves_nothing_and_is_answered(unspoken, text):
    inbox = Inbox()
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED), inbox=inbox)
    running = episode.steps()
    steps = list(islice(running, 40))
    inbox.say(text)
    steps += islice(running, 60)
    np.testing.assert_array_equal(commands(steps), commands(unspoken[:100]))
    (heard,) = steps[40].heard
    assert heard.instruction is None
    assert heard.reply.endswith(f"I go on: {steps[40].instruction.text}.")


@pytest.mark.parametrize(
    "word",
    ["stop", "don't cut", "that's the wrong tube", "arrête",
     *map(slow, ["pause", "no no no", "wait don't clip that", "whoa", "nicht schneiden",
                 "be careful, you are too close to the bile duct"])],
)  # fmt: skip
def test_a_stop_or_a_warning_changes_no_joint_command_from_then_on(word):
    steps, _ = steps_of((1.5, word), n=120)
    before = round(1.5 / STEP_S)
    assert abs(steps[before - 1].command.joints - steps[before - 2].command.joints).max() > 1e-4
    still = np.broadcast_to(steps[before - 1].command.joints, (120 - before, 2, 7))
    np.testing.assert_allclose(commands(steps[before:]), still, rtol=0, atol=1e-9)


def test_a_stop_does_not_drop_the_gallbladder():
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED))
    running = episode.steps()
    last = next(step for step in running if gallbladder_grasped(episode.world))
    jaw_rad = last.command.joints[LEFT_ARM, 6]
    assert last.observation.joints[LEFT_ARM, 6] > jaw_rad + 1e-3  # tissue keeps the jaws apart
    episode.inbox.press(COMMANDS["stop"])
    for step in islice(running, 60):
        assert step.command.joints[LEFT_ARM, 6] == pytest.approx(jaw_rad, abs=1e-9)
        assert gallbladder_held(episode.world)


def test_a_stop_breaks_an_exchange_off_and_it_is_done_later():
    planner = Saying(Instruction(task=TASKS[7]))
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED), planner=planner)
    running = episode.steps()
    exchanging = list(islice(running, 10))
    assert all(step.exchange for step in exchanging)
    episode.inbox.press(COMMANDS["stop"])
    held = list(islice(running, 30))
    assert not any(step.exchange for step in held)
    still = np.broadcast_to(exchanging[-1].command.joints, (30, 2, 7))
    np.testing.assert_allclose(commands(held), still, rtol=0, atol=1e-9)
    episode.inbox.press(COMMANDS["resume"])
    resumed = list(takewhile(lambda step: step.exchange, running))
    assert len(resumed) == round(2 * EXCHANGE_S / STEP_S)
    assert resumed[-1].observation.tools[RIGHT_ARM] == "scissors"


def test_of_two_texts_within_a_second_the_later_is_obeyed_and_both_are_logged():
    steps, episode = steps_of((0.5, LEFT), (0.7, HIGHER), n=30)
    assert [h.text for s in steps for h in s.heard] == [LEFT, HIGHER]
    assert steps[-1].instruction.text == HIGHER
    assert episode.tasks.results[1].corrections == 2


def test_the_same_correction_given_twice_counts_twice_and_a_planner_repeating_its_own_once():
    assert steps_of((0.5, HIGHER), (1.0, HIGHER), n=60)[1].tasks.results[1].corrections == 2
    said = Instruction(task=TASKS[0], correction=CORRECTIONS[0])
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED), planner=Saying(said))
    list(islice(episode.steps(), 100))
    assert episode.tasks.results[1].corrections == 1


def test_the_planners_task_may_be_done_under_another_instruction():
    planner = Saying(Instruction(task=TASKS[2]))  # "going back": the arm is back already
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED), planner=planner)
    episode.inbox.press(COMMANDS[TASKS[0].text])
    list(islice(episode.steps(), 10))
    assert {k: task.success for k, task in episode.tasks.results.items()} == {1: False, 3: True}
    results = episode.tasks.results
    assert (results[1].time_s, results[3].time_s) == (pytest.approx(10 * STEP_S), 0.0)
