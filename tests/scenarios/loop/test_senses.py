"""Tests of senses from outside: a factory of one's own makes what everybody who acts observes."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from scenarios.catalogue import ORACLE, sense_named
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.attempt import attempt_episode
from scenarios.recording.first_difference import first_difference
from scenarios.recording.recorder import load
from scenarios.recording.rerun_decisions import repeat
from scenarios.run_episode import begin
from tests.scenarios.from_the_shell.complaint import complaint
from tissue_sim.sensing.sensor_model import SenseSetup

OFFSET_M = 0.002
HIGHER, RENDERED = f"{__name__}:Higher", f"{__name__}:make_rendered"
CONFIG = EpisodeConfig(
    **ORACLE | {"sense": HIGHER, "controller": "idle"}, scenario="textbook", seed=10_004
)


class Higher:
    """Observes both tips higher than they are."""

    def __init__(self, setup: SenseSetup):
        self.seed = setup.seed

    def observe(self, world, exact):
        tips = exact.tips_endoscope.copy()
        tips[:, 1, 3] += OFFSET_M
        return replace(exact, tips_endoscope=tips)


def make_rendered(setup: SenseSetup):
    return Higher(setup)


make_rendered.renders = True


def test_everybody_who_acts_observes_by_the_outside_sense():
    step = next(islice(begin(CONFIG).steps(), 1))
    off_m = step.observation.tips_endoscope[:, :3, 3] - step.exact.tips_endoscope[:, :3, 3]
    np.testing.assert_allclose(off_m, 2 * [[0.0, OFFSET_M, 0.0]], atol=1e-12)


def test_an_outside_sense_tells_what_it_is_and_whether_it_needs_pictures():
    assert sense_named(HIGHER).description == "Observes both tips higher than they are."
    assert [sense_named(name).renders for name in (HIGHER, RENDERED)] == [False, True]


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("no_such_module:make", "no_such_module"),
        (f"{__name__}:CONFIG", "not a factory"),
        ("nothing", "MODULE:FACTORY"),
    ],
)
def test_a_sense_that_cannot_be_made_is_bad_input(capfd, tmp_path, name, says):
    line = complaint(capfd, "run", "--sense", name, "--out", str(tmp_path / "out"))
    assert says in line


def test_a_recording_that_names_a_sense_of_its_own_is_not_run_without_leave(tmp_path):
    config, files = replace(CONFIG, task_cap_s=0.3), tmp_path / "episodes"
    attempt_episode(config, tmp_path)
    recording = load(files / f"{config.seed}.npz")
    with pytest.raises(ValueError, match="--sense"):
        repeat(recording, tmp_path / "again", allowed=frozenset())
    again = repeat(recording, tmp_path / "again", allowed=frozenset({HIGHER}))
    assert first_difference(recording, again) is None
