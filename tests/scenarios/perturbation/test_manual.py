"""Tests of manual perturbations: they start at once, are logged, and the body swings back."""

from itertools import islice

import numpy as np
import pytest

from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.inbox import Inbox
from scenarios.perturbation.body import NUDGE_S
from scenarios.perturbation.perturbations import MANUAL
from scenarios.run_episode import begin

STEP_S = 1 / 30


def disturbed(name, n=70):
    """Return the steps of an episode disturbed before step 11, the world, its state before that."""
    inbox = Inbox()
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=10_006), inbox=inbox)
    running = episode.steps()
    steps = list(islice(running, 10))
    before = episode.world.T_world_endoscope.copy(), episode.world.record.clip_loaded
    inbox.disturb(MANUAL[name])
    offsets_m = []
    for step in islice(running, n):
        steps.append(step)
        offsets_m.append(np.linalg.norm(episode.world.body.offset_m))
    return steps, episode.world, before, np.array(offsets_m)


@pytest.mark.parametrize("name", MANUAL)
def test_it_starts_at_once_happens_once_and_is_logged(name):
    steps, *_ = disturbed(name, n=20)
    told = [(k, a.name) for k, step in enumerate(steps) for a in step.applied]
    assert told == [(10, name)]


def test_a_nudge_pushes_the_body_as_far_as_it_says_and_lets_it_come_back():
    *_, offsets_m = disturbed("nudge the tissue")
    assert offsets_m.max() == pytest.approx(MANUAL["nudge the tissue"].magnitude, rel=0.02)
    assert offsets_m[round(NUDGE_S / STEP_S) + 2 :].max() < 1e-9


def test_the_clip_falls():
    _, world, (_, loaded), _ = disturbed("drop the clip", n=1)
    assert loaded
    assert not world.record.clip_loaded
    assert world.record.dropped_clips == 1


def test_the_camera_is_shifted_by_as_much_as_it_says():
    _, world, (T_before, _), _ = disturbed("shift the camera", n=1)
    shift_m = np.linalg.norm(world.T_world_endoscope[:3, 3] - T_before[:3, 3])
    assert shift_m == pytest.approx(MANUAL["shift the camera"].magnitude)
