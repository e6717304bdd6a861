"""Tests of the third outcome: an episode in which the planner asks for a person."""

import json
from dataclasses import replace

import pytest

from planner.command import COMMANDS
from planner.instruction import CALL, TASKS
from planner.person.orders import GRAB_S, HELD_S
from planner.policy_setup import PolicySetup
from scenarios.catalogue import ORACLE
from scenarios.cli import main
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.inbox import Inbox
from scenarios.recording.verify import verify
from scenarios.run_episode import anatomy_of, begin, play, run_episode
from scenarios.viewer.recording_frames import marks_of
from tests.scenarios.calling import UNSURE, PlannerCalls
from tests.scenarios.example_results import read_results
from tests.scenarios.procedures import run
from tests.tissue_sim.kinds import SLIM_APPLIER
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m
from tissue_sim.outcome.room import why_call

SEED = 10_004
TOO_SHORT = EpisodeConfig(**ORACLE, seed=SEED, scenario="short-tubes", magnitude=1.0)
CALLS = EpisodeConfig(
    scenario="textbook",
    planner="tests.scenarios.calling:PlannerCalls",
    controller="idle",
    seed=SEED,
)


@pytest.fixture(scope="module")
def too_short(tmp_path_factory):
    return run(TOO_SHORT, tmp_path_factory.mktemp("short"))


def test_a_short_duct_ends_as_called_within_a_second_with_nothing_clipped(too_short):
    result, record, anatomy = too_short.result, too_short.world.record, too_short.world.anatomy
    assert anatomy.duct_length_m < needed_m("duct", SLIM_APPLIER, FEWEST_CLIPS)
    assert result.outcome == "called"
    assert result.call.needed
    assert result.call.reason == why_call(anatomy)
    assert result.call.reason.startswith(f"The duct is {1e3 * anatomy.duct_length_m:.1f} mm long")
    assert (record.clips, record.cuts, record.injuries) == ((), (), ())
    assert 0.0 < result.procedure_time_s < 1.0
    assert [(task.index, task.success) for task in result.tasks] == [(1, False)]


def test_both_arms_hold_while_it_calls(too_short):
    for step in too_short.steps:
        assert step.instruction.text == CALL
        assert not step.asked.move_endoscope_m.any()


def test_a_called_episode_run_again_is_identical_and_its_recording_says_why(too_short):
    assert verify(too_short.file).outcome == "identical"
    said = too_short.recording.instructions
    assert [(entry["text"], entry["remark"]) for entry in said] == [
        (CALL, too_short.result.call.reason)
    ]
    assert marks_of(too_short.recording)[-1].text == too_short.result.call.in_words


def test_another_reason_is_a_difference(too_short, tmp_path):
    other = run(replace(CALLS, scenario="short-tubes", magnitude=1.0), tmp_path)
    assert other.result.call.needed  # although for another reason
    assert other.recording.instructions != too_short.recording.instructions


def test_a_call_where_all_could_be_done_is_told_apart():
    result = run_episode(CALLS)
    assert why_call(anatomy_of(CALLS)) is None
    assert (result.outcome, result.call.reason, result.call.needed) == ("called", UNSURE, False)
    assert result.call.in_words == f"called without need: {UNSURE}"
    assert result.is_needless_call


def test_a_call_after_a_clip_is_a_failure_that_keeps_its_reason(procedure):
    world, before = procedure.world, procedure.world.state()
    try:
        episode = replace(
            begin(CALLS),
            world=world,
            observation=world.observe(),
            planner=PlannerCalls(PolicySetup()),
        )
        result = play(episode, (), 0.0)
    finally:
        world.restore(before)
    assert result.outcome == "failed"
    assert not result.success
    assert (result.call.in_time, result.call.reason) == (False, UNSURE)
    assert result.injuries == ()  # and nobody pulls at the clips, as all is not done


def test_a_person_who_gives_an_order_is_heard_first():
    inbox = Inbox()
    inbox.press(COMMANDS[TASKS[0].text])
    episode = begin(TOO_SHORT, inbox=inbox)
    said = [(step.instruction.source, step.instruction.text) for step in episode.steps()]
    assert said[-1] == ("planner", CALL)
    assert set(said[:-1]) == {("human", TASKS[0].text)}
    assert HELD_S * 30 < len(said) - 1 <= GRAB_S * 30 + 2


def test_the_command_says_why_and_ends_well_if_the_call_was_right(too_short, tmp_path, capfd):
    oracle = ["--planner", "scripted", "--controller", "expert"]
    where = ["--scenario", "short-tubes", "--magnitude", "1", "--seed", str(SEED)]
    assert main(["run", *oracle, *where, "--out", str(tmp_path)]) == 0
    told = capfd.readouterr().out
    assert f"seed {SEED} called rightly: {too_short.result.call.reason}" in told
    assert "passed 0 of 0" in told
    assert "1 called for a person (100 %)" in told
    (result,) = read_results(tmp_path / "results.json")
    assert result.outcome == "called"
    summary = json.loads((tmp_path / "results.json").read_text())["summary"]
    assert (summary["called"], summary["needless"], summary["pass_rate"]) == (1, 0, None)
