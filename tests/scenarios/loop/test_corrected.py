"""Tests of how arms move that a person corrects: in an exchange, in a hold and at work."""

from dataclasses import replace
from itertools import islice, takewhile

import numpy as np
import pytest

from controller.action import hold
from controller.kept_place import STAYS_S
from planner.correction import DIRECTION_ENDOSCOPE, correction_from_text
from planner.instruction import TASKS, Instruction
from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.guided_arm import GuidedArm
from scenarios.run_episode import begin
from tests.scenarios.loop.saying import Saying
from tests.slow import slow
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import SLIM_CLIP_APPLIER

SEED = 10_004
JAW_RAD = 0.5  # to which a person opens jaws
UP = correction_from_text("move right arm higher")
LEFT_UP = correction_from_text("move left arm higher")
EXCHANGE = Instruction(task=TASKS[7])  # the right arm needs scissors
RIGHT_ARM_OUT = round(0.7 / CONTROL_PERIOD_S)


class ControllerDrifts:
    """Lets both tips drift, and both jaws close."""

    move_m = np.array([[2e-4, 0.0, 0.0], [0.0, 0.0, -2e-4]])

    def __init__(self):
        self.resets = 0

    def reset(self):
        self.resets += 1

    def act(self, observation, instruction):
        closing = hold(observation.joints[:, 6] - 0.01)
        return (replace(closing, move_endoscope_m=self.move_m),)


def episode_of(instruction=None, controller=None, **config):
    """Return an episode whose right arm holds the applier for the patient's tubes."""
    episode = begin(
        EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED, **config),
        planner=Saying(instruction or Instruction(task=TASKS[1])),
        controller=controller or ControllerDrifts(),
    )
    episode.world.equip(SLIM_CLIP_APPLIER)
    episode.guarded_driver.restart(episode.world.target)
    episode.observation = episode.world.observe()
    return episode


def seconds(time_s):
    return round(time_s / CONTROL_PERIOD_S)


def tips_m(steps):
    return np.stack([step.exact.tips_endoscope[:, :3, 3] for step in steps])


def commands(steps):
    return np.stack([step.command.joints for step in steps])


def told(steps):
    return [line for step in steps for line in step.told]


def along_m(tips, correction):
    return (tips[:, correction.rows[0]] - tips[0, correction.rows[0]]) @ np.array(
        DIRECTION_ENDOSCOPE[correction.direction]
    )


@pytest.mark.parametrize("said_after", [1, RIGHT_ARM_OUT, 2 * RIGHT_ARM_OUT])
def test_a_correction_said_in_an_exchange_goes_its_distance_from_its_end(said_after):
    episode = episode_of(EXCHANGE)
    running = episode.steps()
    exchange = list(islice(running, said_after))
    episode.inbox.say("right arm up 5 mm")
    exchange += takewhile(lambda step: step.exchange, running)
    heard = exchange[said_after].heard[0]
    assert "by 5 mm, once the tool is exchanged." in heard.reply
    moved = [exchange[-1], *takewhile(lambda step: not told([step]), running)]
    (gone_m,) = along_m(tips_m(moved), UP)[[-1]]
    assert gone_m == pytest.approx(0.005, abs=2e-4)


def test_no_exchange_begins_in_a_hold_or_while_a_person_moves_an_arm_or_it_stays():
    episode = episode_of()
    running = episode.steps()
    list(islice(running, 5))
    episode.planner.says(EXCHANGE)
    episode.inbox.say("left arm up 12 mm")
    corrected = list(takewhile(lambda step: not told([step]), running))
    assert corrected[-1].instruction.task == TASKS[7]  # the planner has asked for scissors
    assert not any(step.exchange for step in corrected)
    assert not any(step.exchange for step in islice(running, seconds(STAYS_S) - 2))
    episode.inbox.say("pause")
    held = list(islice(running, 20))
    episode.inbox.say("left arm up 2 mm")
    held += islice(running, seconds(2.0))
    assert not any(step.exchange for step in held[1:])
    episode.inbox.say("resume")
    assert any(step.exchange for step in islice(running, seconds(2.0)))


@pytest.mark.parametrize("why", ["pause", *map(slow, ["wait", "don't clip anything"])])
@pytest.mark.parametrize("text", ["right arm up 3 mm", "left arm up 3 mm", "open left gripper"])
def test_what_is_not_named_rests_during_a_correction_in_a_hold(why, text):
    episode = episode_of()
    running = episode.steps()
    list(islice(running, 20))
    episode.inbox.say(why)
    before = list(islice(running, seconds(1.1)))[-1]
    episode.inbox.say(text)
    steps = list(islice(running, seconds(2.5)))
    other = LEFT_ARM if "right" in text else RIGHT_ARM
    still = np.broadcast_to(before.command.joints[other], (len(steps), 7))
    np.testing.assert_allclose(commands(steps)[:, other], still, rtol=0, atol=1e-9)
    assert any(line.startswith("Done: ") for line in told(steps))
    assert steps[-1].instruction.hold
    assert np.abs(commands(steps)[-1, 1 - other] - before.command.joints[1 - other]).max() > 1e-3


def test_a_corrected_arm_stays_for_a_while_and_the_task_goes_on_from_there():
    episode = episode_of()
    running = episode.steps()
    list(islice(running, 20))
    episode.inbox.say("right arm up 3 mm")
    list(takewhile(lambda step: not told([step]), running))
    stays = list(islice(running, seconds(STAYS_S) - 1))
    still = np.broadcast_to(stays[0].command.joints[RIGHT_ARM], (len(stays), 7))
    np.testing.assert_allclose(commands(stays)[:, RIGHT_ARM], still, rtol=0, atol=1e-9)
    assert np.ptp(tips_m(stays)[:, LEFT_ARM, 0]) > 0.01  # it is the controller's
    goes_on = list(islice(running, 30))
    assert tips_m(goes_on)[-1, RIGHT_ARM, 2] < tips_m(goes_on)[0, RIGHT_ARM, 2] - 0.003
    assert np.diff(commands(goes_on)[:, RIGHT_ARM, 6]).min() > -1e-9  # its jaws wait


def test_a_word_ends_the_stay():
    episode = episode_of()
    running = episode.steps()
    list(islice(running, 20))
    episode.inbox.say("right arm up 1 mm")
    list(takewhile(lambda step: not told([step]), running))
    episode.inbox.say("resume")
    steps = list(islice(running, 10))
    assert np.abs(np.diff(commands(steps)[:, RIGHT_ARM], axis=0)).max() > 1e-4


def test_a_tasks_time_does_not_run_in_a_hold_and_an_endless_hold_ends():
    episode = episode_of(task_cap_s=3.0)
    running = episode.steps()
    list(islice(running, seconds(1.0)))
    for why in ("stop", "don't clip anything"):
        episode.inbox.say(why)
        assert len(list(islice(running, seconds(4.0)))) == seconds(4.0)
    episode.inbox.say("resume")  # what is due is forbidden: the arms hold on
    assert len(list(islice(running, seconds(4.0)))) == seconds(4.0)
    assert episode.tasks.results[2].time_s == pytest.approx(1.0)
    episode.inbox.say("you may clip")
    left = [step for step in running if not step.exchange]
    assert len(left) == pytest.approx(seconds(2.0), abs=2)


def test_an_episode_that_nobody_goes_on_with_ends(monkeypatch):
    monkeypatch.setattr("scenarios.episode.MOST_HELD_S", 2.0)
    episode = episode_of()
    episode.inbox.say("stop")
    assert len(list(episode.steps())) == pytest.approx(seconds(2.0), abs=2)


@pytest.mark.parametrize("hold_first", [False, True])
def test_an_arm_that_was_led_by_hand_stays_where_it_was_let_go(hold_first):
    episode = episode_of()
    running = episode.steps()
    list(islice(running, 20))
    if hold_first:
        episode.inbox.say("pause")
        list(islice(running, seconds(1.1)))
    goal = episode.world.arms.T_world_tool()[RIGHT_ARM].copy()
    goal[:3, 3] += episode.world.T_world_endoscope[:3, :3] @ [0.0, 0.0, -0.004]
    episode.inbox.guided = GuidedArm(arm=RIGHT_ARM, T_world_goal=goal, jaw_rad=JAW_RAD)
    list(islice(running, seconds(1.5)))
    episode.inbox.guided = None
    stays = list(islice(running, seconds(STAYS_S) - 1))
    jaw_rad = commands(stays)[5:, RIGHT_ARM, 6]
    np.testing.assert_allclose(jaw_rad, jaw_rad[0], rtol=0, atol=1e-9)
    assert jaw_rad[0] == pytest.approx(JAW_RAD, abs=0.02)
    moved_m = np.ptp(tips_m(stays[5:])[:, RIGHT_ARM], axis=0)
    assert moved_m.max() < 5e-4
    assert told(stays) == (
        []
        if hold_first
        else [f"The right arm stays there for {STAYS_S:g} s, or until you say something else."]
    )
    episode.inbox.say("resume")
    jaws = commands(list(islice(running, 15)))[:, RIGHT_ARM, 6]
    assert np.diff(jaws).min() > -1e-9  # they wait until the arm rests
