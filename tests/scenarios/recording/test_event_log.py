"""Tests of the event log: which events are logged once or again, and how times add up."""

from dataclasses import replace
from itertools import islice

import pytest

from controller.safety.ledger import APART_S, Entry
from planner.instruction import CORRECTIONS, TASKS, Instruction
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.event_log import EventLog
from scenarios.run_episode import begin

STEP_S = 1 / 30


@pytest.fixture(scope="module")
def step():
    """Return a real step in which nothing happens."""
    episode = begin(EpisodeConfig(scenario="textbook", seed=10_003, controller="idle"))
    (step,) = islice(episode.steps(), 1)
    return step


def interventions(step, *times_s, limits=("keep-out: right wrist to liver",)):
    """Return the times that the log shows if the safety filter alters commands at `times_s`."""
    log = EventLog()
    for time_s in times_s:
        log.note(replace(step, time_s=time_s, altered=(Entry(time_s=time_s, limits=limits),)))
    return [line.time_s for line in log.status.lines if line.kind == "filter"]


def test_alterations_without_a_pause_are_logged_once_however_long_they_take(step):
    times_s = [STEP_S * k for k in range(round(5 * APART_S / STEP_S))]
    assert interventions(step, *times_s) == [0.0]


def test_an_alteration_after_a_pause_is_logged_again(step):
    assert interventions(step, 1.0, 1.0 + 0.9 * APART_S) == [1.0]
    assert interventions(step, 1.0, 1.0 + 1.1 * APART_S) == [1.0, 1.0 + 1.1 * APART_S]


def test_another_limit_is_logged_apart_and_every_altered_command_is_counted(step):
    log = EventLog()
    for k, limit in enumerate(("tip speed", "remote centre", "tip speed")):
        time_s = STEP_S * k
        log.note(replace(step, time_s=time_s, altered=(Entry(time_s=time_s, limits=(limit,)),)))
    told = [line.text for line in log.status.lines if line.kind == "filter"]
    assert told == ["tip speed", "remote centre"]
    assert log.status.altered == 3


def test_each_steps_time_goes_to_its_task(step):
    log = EventLog()
    for k in range(1, 31):
        task = TASKS[0] if k <= 10 else TASKS[1]
        log.note(replace(step, time_s=STEP_S * k, instruction=Instruction(task=task)))
    tasks = log.status.tasks
    assert tasks[TASKS[0].index].time_s == pytest.approx(10 * STEP_S)
    assert tasks[TASKS[1].index].time_s == pytest.approx(20 * STEP_S)


def test_the_times_of_tasks_are_those_of_the_result(procedure):
    """An exchange of tools is no time of a task, nor of the 90 s that a task may last."""
    log = EventLog()
    for step in procedure.steps:
        log.note(step)
    assert any(step.exchange for step in procedure.steps)
    shown_s = {index: progress.time_s for index, progress in log.status.tasks.items()}
    assert shown_s == {task.index: pytest.approx(task.time_s) for task in procedure.result.tasks}


def test_a_persons_hold_is_no_time_of_a_task(step):
    log = EventLog()
    for k in range(1, 31):
        log.note(replace(step, time_s=STEP_S * k, held=k > 10))
    (progress,) = log.status.tasks.values()
    assert progress.time_s == pytest.approx(10 * STEP_S)


@pytest.mark.parametrize(("source", "corrections"), [("planner", 1), ("human", 2)])
def test_a_correction_counts_when_it_begins_and_a_persons_each_time_it_is_said(
    step, source, corrections
):
    """Count a planner's correction once: the planner repeats it for as long as it is needed."""
    log = EventLog()
    for k in range(10):
        said_s = 0.0 if k < 5 else 5 * STEP_S
        said = Instruction(task=TASKS[0], correction=CORRECTIONS[0], source=source, time_s=said_s)
        log.note(replace(step, time_s=STEP_S * k, instruction=said))
    assert log.status.tasks[TASKS[0].index].corrections == corrections


def test_a_copy_that_was_read_does_not_change(step):
    log = EventLog()
    log.note(step)
    before = log.status
    kept = (dict(before.tasks), before.lines, dict(before.spent_s), before.time_s)
    log.note(replace(step, time_s=step.time_s + 1.0, altered=(Entry(time_s=1.0, limits=("x",)),)))
    assert (dict(before.tasks), before.lines, dict(before.spent_s), before.time_s) == kept
    assert len(log.status.lines) > len(before.lines)
