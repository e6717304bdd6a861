"""Tests of a session: people act on it from any thread, and nothing they do ends it."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from controller.dataset.part import read_part
from controller.dataset.reader import read_episodes
from planner.command import COMMANDS
from planner.instruction import CALL, CORRECTIONS
from scenarios.loop.person.inbox import LONGEST
from scenarios.perturbation.perturbations import MANUAL
from scenarios.recording.event_log import KEPT
from scenarios.recording.recorder import load
from tests.scenarios.viewer.sessions import SEED, run_to, running_session, wait_until


@pytest.fixture
def session(tmp_path):
    with running_session(tmp_path, speed=math.inf) as session:
        yield session


def recorded(session):
    """Begin another episode, which closes the current one; return the recording."""
    path = session.out / "episodes" / f"{session.config.seed}.npz"
    path.unlink(missing_ok=True)
    session.pace.restart(session.config)
    wait_until(path.exists)
    return load(path)


def test_nothing_is_copied_unless_the_page_asks(session):
    first = session.watcher.frame
    session.pace.go_on()
    run_to(session, 0.5)
    assert session.watcher.frame is first
    session.watcher.ask()
    wait_until(lambda: session.watcher.frame is not first)
    assert session.watcher.frame.time_s >= 0.5


def test_a_paused_episode_still_answers_the_page(session):
    session.pace.step()
    run_to(session, 1 / 30 - 1e-9)
    session.watcher.ask()
    wait_until(lambda: session.watcher.frame.time_s > 0.0)
    time.sleep(0.2)
    assert session.watcher.status().time_s == pytest.approx(1 / 30)


def test_50_clicks_a_second_are_all_heard_in_order(session):
    session.pace.go_on()
    texts = [CORRECTIONS[k % 18].text for k in range(100)]
    for text in texts:
        session.press(text)
        time.sleep(0.02)
    run_to(session, session.watcher.status().time_s + 0.2)
    assert [heard["text"] for heard in recorded(session).heard] == texts


def test_a_text_of_100_kb_holds_the_arms_because_a_stop_may_be_in_it(session):
    session.pace.go_on()
    reading = session.inbox.say("blah " * 20_000)
    assert reading.command == COMMANDS["stop"]
    run_to(session, 0.5)
    assert session.watcher.status().instruction.hold
    (heard,) = recorded(session).heard
    assert len(heard["text"]) == LONGEST


def test_events_are_logged_and_the_log_is_bounded(session):
    session.pace.go_on()
    for _ in range(KEPT + 50):
        session.press("move right arm higher")
    for name in MANUAL:
        session.disturb(name)
    run_to(session, 0.5)
    status = session.watcher.status()
    assert len(status.lines) == KEPT
    assert {line.text for line in status.lines if line.kind == "disturbance"} == set(MANUAL)
    assert status.instruction.source == "human"
    assert {"world", "safety filter", "controller"} <= status.spent_s.keys()


def test_another_patient_hears_nothing_that_was_said_to_the_previous_one(session):
    session.press("move right arm higher")
    before = session.watcher.patient
    session.pace.restart(replace(session.config, seed=SEED + 1, scenario="fat"))
    wait_until(lambda: session.watcher.patient is not before)
    assert session.config.seed == SEED + 1
    session.pace.go_on()
    run_to(session, 0.3)
    assert recorded(session).heard == ()


def test_each_episode_of_a_seed_is_recorded_in_a_file_of_its_own(session):
    texts = ("move right arm higher", "move left arm lower")
    for text in texts:
        session.press(text)
        session.pace.go_on()
        run_to(session, 0.2)
        session.pace.pause()
        before = session.watcher.patient
        session.pace.restart(replace(session.config, scenario="fat"))
        wait_until(lambda before=before: session.watcher.patient is not before)
    files = [session.out / "episodes" / f"{SEED}{end}.npz" for end in ("", "-2")]
    assert [[heard["text"] for heard in load(file).heard] for file in files] == [[t] for t in texts]


def test_an_episode_that_breaks_off_is_logged_and_the_next_one_begins(session):
    session.pace.restart(replace(session.config, controller="diffusion", checkpoint="nowhere"))
    wait_until(lambda: session.watcher.status().result is not None)
    assert "error: " in session.watcher.status().lines[-1].text
    session.pace.restart(replace(session.config, controller="expert", checkpoint=None))
    wait_until(lambda: session.watcher.status().result is None)
    session.pace.go_on()
    run_to(session, 0.2)


def test_an_episode_in_which_a_person_is_called_ends_and_says_why(session):
    session.pace.restart(replace(session.config, scenario="short-tubes", magnitude=1.0))
    session.pace.go_on()
    wait_until(lambda: session.watcher.status().result is not None)
    called, disturbed, end = session.watcher.status().lines
    assert (disturbed.kind, disturbed.text) == ("disturbance", "short-tubes")
    assert (called.kind, called.text) == ("planner", CALL)
    assert called.detail.startswith("The duct is ")
    assert (end.kind, end.text) == ("end", f"called rightly: {called.detail}")


def test_an_episode_is_one_of_training_data_however_often_it_is_saved(session):
    with pytest.raises(ValueError, match="nobody has corrected"):
        session.interventions.save_so_far()
    session.pace.go_on()
    run_to(session, 0.1)
    session.press("move left arm lower")
    wait_until(lambda: session.interventions.intervened)
    session.interventions.save_so_far()
    run_to(session, session.watcher.status().time_s + 0.5)
    path = session.interventions.save_so_far()
    episode = read_part(path)
    assert set(episode.columns["correction"]) == {"move left arm lower", ""}
    assert np.all(episode.columns["expert"])
    (saved,) = read_episodes(session.out / "interventions")
    assert len(saved) == len(episode)


def test_another_episode_is_saved_to_another_file(session):
    paths = []
    for _ in range(2):
        session.pace.go_on()
        session.press("move left arm lower")
        wait_until(lambda: session.interventions.intervened)
        session.pace.pause()
        paths.append(session.interventions.save_so_far())
        before = session.watcher.patient
        session.pace.restart(session.config)
        wait_until(lambda before=before: session.watcher.patient is not before)
    assert len(set(paths)) == len(list(read_episodes(session.out / "interventions"))) == 2


def test_a_command_that_does_not_exist_is_refused(session):
    with pytest.raises(KeyError):
        session.press("do a somersault")
