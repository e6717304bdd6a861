"""Laws of interventions as training data: loadable, labelled, honest about who led."""

from itertools import islice

import numpy as np
import pytest

from controller.dataset.part import read_part
from planner.command import COMMANDS
from scenarios.episode import begin
from scenarios.episode_config import EpisodeConfig
from scenarios.hand import Hand
from scenarios.inbox import Inbox
from scenarios.viewer.interventions import Interventions, labelled
from tissue_sim.arms import RIGHT_ARM

HIGHER = "move right arm higher"


def test_a_correction_labels_the_second_before_it_too():
    said = ["", ""] * 30 + ["up"] * 3 + [""] * 4
    wanted = labelled(said)
    assert wanted == [""] * 30 + ["up"] * 33 + [""] * 4


def test_a_correction_before_takes_its_own_frames_with_it():
    assert labelled(["down", "down", "up"]) == ["down", "down", "up"]
    assert labelled([]) == []


@pytest.fixture(scope="module", params=["expert", "idle"])
def saved(request, tmp_path_factory):
    """Of 100 steps: a correction from 40 on, holding from 60 to 70, a hand from 80 on."""
    config, inbox = EpisodeConfig(seed=10_002, controller=request.param), Inbox()
    episode, seen = begin(config, inbox=inbox), Interventions(config)
    seen.on_reset(episode.world)
    with pytest.raises(ValueError, match="no frame yet"):
        seen.part()
    for k, step in enumerate(islice(episode.steps(), 100), start=1):
        seen.on_step(step)
        if k == 40:
            inbox.press(COMMANDS[HIGHER])
        if k == 60:
            inbox.press(COMMANDS["pause"])
        if k == 70:
            inbox.press(COMMANDS["resume"])
        if k == 80:
            T = episode.world.arms.T_world_tool()[RIGHT_ARM]
            inbox.hand = Hand(arm=RIGHT_ARM, T_world_goal=T, jaw_rad=0.3)
    path = tmp_path_factory.mktemp("saved") / "part.parquet"
    path.write_bytes(seen.part())
    return request.param, read_part(path), seen


def test_frames_in_which_the_arms_held_are_left_out(saved):
    _, episode, _ = saved
    assert len(episode) == 90
    assert len(np.unique(episode.columns["segment"])) == 2


def test_the_correction_stands_on_its_frames_and_the_second_before(saved):
    _, episode, seen = saved
    flag, correction = episode.columns["flag"], episode.columns["correction"]
    assert np.flatnonzero(flag).tolist() == list(range(10, 60))
    assert set(correction[flag]) == {HIGHER}
    assert set(correction[~flag]) == {""}
    assert set(episode.columns["instruction"][40:60]) == {HIGHER}
    assert seen.corrected == 20 + 20


def test_only_the_expert_and_a_hand_are_to_be_imitated(saved):
    controller, episode, _ = saved
    by_hand = np.arange(90) >= 70
    expected = by_hand if controller == "idle" else np.ones(90, bool)
    np.testing.assert_array_equal(episode.columns["expert"], expected)
