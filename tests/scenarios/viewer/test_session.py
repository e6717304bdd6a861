"""Laws of a session: people act on it from any thread, nothing they do ends it."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from controller.dataset.part import read_part
from controller.dataset.reader import read_episodes
from planner.instruction import CORRECTIONS
from scenarios.loop.inbox import LONGEST
from scenarios.perturbation.by_hand import BY_HAND
from scenarios.recording.recorder import load
from scenarios.viewer.event_log import KEPT
from tests.scenarios.viewer.sessions import SEED, run_to, session, wait_until


@pytest.fixture
def desk(tmp_path):
    with session(tmp_path, speed=math.inf) as desk:
        yield desk


def recorded(desk):
    """The episode so far: another one is begun, which closes it."""
    path = desk.out / "episodes" / f"{desk.config.seed}.npz"
    path.unlink(missing_ok=True)
    desk.pace.restart(desk.config)
    wait_until(path.exists)
    return load(path)


def test_nothing_is_copied_unless_the_page_asks(desk):
    first = desk.watcher.frame
    desk.pace.go_on()
    run_to(desk, 0.5)
    assert desk.watcher.frame is first
    desk.watcher.ask()
    wait_until(lambda: desk.watcher.frame is not first)
    assert desk.watcher.frame.time_s >= 0.5


def test_a_paused_episode_still_answers_the_page(desk):
    desk.pace.step()
    run_to(desk, 1 / 30 - 1e-9)
    desk.watcher.ask()
    wait_until(lambda: desk.watcher.frame.time_s > 0.0)
    time.sleep(0.2)
    assert desk.watcher.story().time_s == pytest.approx(1 / 30)


def test_50_clicks_a_second_are_all_heard_in_order(desk):
    desk.pace.go_on()
    texts = [CORRECTIONS[k % 18].text for k in range(100)]
    for text in texts:
        desk.press(text)
        time.sleep(0.02)
    run_to(desk, desk.watcher.story().time_s + 0.2)
    assert [heard["text"] for heard in recorded(desk).heard] == texts


def test_a_text_of_100_kb_is_asked_back_and_nothing_moves(desk):
    desk.pace.go_on()
    reading = desk.inbox.say("blah " * 20_000)
    assert reading.command is None
    run_to(desk, 0.5)
    (heard,) = recorded(desk).heard
    assert heard["instruction"] is None
    assert len(heard["text"]) == LONGEST


def test_what_happened_is_told_and_does_not_grow_without_end(desk):
    desk.pace.go_on()
    for _ in range(KEPT + 50):
        desk.press("move right arm higher")
    for name in BY_HAND:
        desk.disturb(name)
    run_to(desk, 0.5)
    story = desk.watcher.story()
    assert len(story.lines) == KEPT
    assert {line.text for line in story.lines if line.kind == "disturbance"} == set(BY_HAND)
    assert story.instruction.source == "human"
    assert {"world", "safety filter", "controller"} <= story.spent_s.keys()


def test_another_patient_comes_and_nothing_said_to_the_one_before_is_heard(desk):
    desk.press("move right arm higher")
    before = desk.watcher.patient
    desk.pace.restart(replace(desk.config, seed=SEED + 1, scenario="fat"))
    wait_until(lambda: desk.watcher.patient is not before)
    assert desk.config.seed == SEED + 1
    desk.pace.go_on()
    run_to(desk, 0.3)
    assert recorded(desk).heard == ()


def test_an_episode_that_breaks_off_is_told_and_the_next_one_begins(desk):
    desk.pace.restart(replace(desk.config, controller="diffusion", checkpoint="nowhere"))
    wait_until(lambda: desk.watcher.story().result is not None)
    assert "broke off" in desk.watcher.story().lines[-1].text
    desk.pace.restart(replace(desk.config, controller="expert", checkpoint=None))
    wait_until(lambda: desk.watcher.story().result is None)
    desk.pace.go_on()
    run_to(desk, 0.2)


def test_an_intervention_is_saved_as_training_data_beside_the_others(desk):
    with pytest.raises(ValueError, match="nobody has corrected"):
        desk.interventions.save_so_far()
    desk.pace.go_on()
    desk.press("move left arm lower")
    run_to(desk, 1.0)
    desk.pace.pause()
    paths = [desk.interventions.save_so_far() for _ in range(2)]
    assert len(set(paths)) == 2
    episode = read_part(paths[0])
    assert set(episode.columns["correction"]) == {"move left arm lower"}
    assert np.all(episode.columns["expert"])
    assert len(list(read_episodes(desk.out / "interventions"))) == 2
    with pytest.raises(KeyError):
        desk.press("do a somersault")
