"""Tests of forks: other commands from the same state, and a demonstration that stays as it is."""

from itertools import islice

import numpy as np
import pytest

from controller.dataset.schema import NOT_FORKED, UNNAMED
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE
from planner.procedure.cholecystectomy import TASKS
from scenarios.demonstration.demonstrate import begun
from scenarios.demonstration.demonstration_recorder import DemonstrationRecorder
from scenarios.demonstration.forks import Forks
from scenarios.demonstration.mix import PlannedDemonstration
from tests.scenarios.from_the_shell.complaint import complaint
from tissue_sim.sensing.observation import fields

STEPS = 200
PLANNED = PlannedDemonstration(seed=10_003, kind="fork:textbook", noise=False)


def demonstrated(*, forked: bool) -> dict[str, np.ndarray]:
    episode, recorder = begun(PLANNED), DemonstrationRecorder(lambda: True)
    forks = Forks(episode, np.random.default_rng(0))
    recorder.on_reset(episode.world)
    for step in islice(episode.steps(), STEPS):
        recorder.on_step(step)
        if forked:
            forks.on_step(step)
    return forks.joined(recorder.columns(0, PLANNED.kind), 0, PLANNED.kind)


@pytest.fixture(scope="module")
def columns(made_once):
    return made_once("forked", lambda _: demonstrated(forked=True))


def forks_of(columns):
    """Yield the rows of each fork."""
    rows = np.flatnonzero(columns["forked_from"] != NOT_FORKED)
    for number in np.unique(columns["segment"][rows]):
        yield rows[columns["segment"][rows] == number]


def test_a_demonstration_with_forks_goes_on_as_without(columns):
    plain, own = demonstrated(forked=False), columns["forked_from"] == NOT_FORKED
    for name in ("privileged.state", "action", "task", "left"):
        np.testing.assert_array_equal(columns[name][own], plain[name])


def test_each_fork_begins_with_the_state_that_the_demonstration_goes_on_from(columns):
    own = np.flatnonzero(columns["forked_from"] == NOT_FORKED)
    forks = list(forks_of(columns))
    assert len(forks) >= 4
    for rows in forks:
        begins = columns["forked_from"][rows[0]]
        assert (columns["forked_from"][rows] == begins).all()
        if begins < len(own):
            state, there = (columns["privileged.state"][k] for k in (rows[0], begins))
            for name in ("tips_endoscope", "tubes_m", "clips_m"):
                np.testing.assert_array_equal(fields(state)[name], fields(there)[name])


def test_forks_of_one_state_have_commands_of_their_own(columns):
    begun = (rows[0] for rows in forks_of(columns))
    names = ("forked_from", "task", "task_index")
    commands = [tuple(int(columns[name][row]) for name in names) for row in begun]
    assert len(set(commands)) == len(commands)


def test_an_arm_goes_the_distance_that_it_is_told_and_the_task_goes_on(columns):
    told = 0
    for rows in forks_of(columns):
        left_m, said = columns["left"][rows, 0], columns["task_index"][rows] - len(TASKS)
        if left_m[0] == UNNAMED or said[0] < 0:
            continue
        told += 1
        under = np.flatnonzero(said >= 0)
        assert (said[under[-1] + 1 :] < 0).all()
        assert len(said) > len(under)
        correction = CORRECTIONS[said[0]]
        tips_m = fields(columns["privileged.state"][rows])["tips_endoscope"][..., 3]
        (arm,), end = correction.rows, under[-1]
        gone_m = (tips_m[end, arm] - tips_m[0, arm]) @ DIRECTION_ENDOSCOPE[correction.direction]
        assert gone_m + left_m[end] == pytest.approx(left_m[0], abs=1e-3)  # it is sensed
        if end < 100:
            assert gone_m == pytest.approx(left_m[0], abs=1e-3)
    assert told >= 3


def test_cameras_do_not_film_forks(tmp_path, capfd):
    words = ["--mix", "forks", "--cameras", "endoscope_left", "--out", str(tmp_path)]
    assert "--cameras" in complaint(capfd, "collect", *words)
