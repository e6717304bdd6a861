"""Tests of a rerun: the same commands and perturbations move the arms the same, bit for bit."""

import json
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.recorder import load
from scenarios.recording.rerun_commands import CommandRerun
from tests.scenarios.interfered import record

SEED = 10_000


UNDISTURBED = pytest.param("textbook", marks=pytest.mark.slow)


@pytest.fixture(scope="module", params=[UNDISTURBED, "breathing", "wrong-tube"])
def recorded(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "episode.npz"
    return *record(path, EpisodeConfig(**ORACLE, seed=SEED, scenario=request.param)), path


def test_arms_and_tissue_are_the_same_bit_for_bit(recorded):
    recording, world, _ = recorded
    assert np.diff(recording.arrays["right_tool"]).any()  # the nurse brought a tool,
    assert np.diff(recording.arrays["clip_loaded"]).max() == 1  # and a clip
    rerun = CommandRerun(recording)
    assert not any(rerun.steps())
    np.testing.assert_array_equal(rerun.world.tissue.positions(), world.tissue.positions())


def test_another_command_is_noticed(recorded):
    recording, *_ = recorded
    arrays = {name: array.copy() for name, array in recording.arrays.items()}
    arrays["commands"][100:, 1, 0] += 1e-4
    unlike = list(islice(CommandRerun(replace(recording, arrays=arrays)).steps(), 110))
    assert [not names for names in unlike] == [True] * 100 + [False] * 10


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"anatomy": {"seed": 1}}, "another patient"),
        ({"config": {"seed": SEED, "laser": True}}, "another version: .*laser"),
        ({"config": {"seed": SEED, "scenario": "earthquake"}}, "unknown scenario 'earthquake'"),
    ],
)
def test_a_recording_of_another_version_is_refused(recorded, change, what):
    with pytest.raises(ValueError, match=what):
        CommandRerun(replace(recorded[0], **change))


@pytest.mark.parametrize("share", [0.0, 0.3, 0.97])
def test_a_file_cut_off_in_the_middle_is_refused(recorded, share, tmp_path):
    whole, cut = recorded[2].read_bytes(), tmp_path / "cut.npz"
    cut.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(ValueError, match="damaged, or no recording"):
        load(cut)


@pytest.mark.parametrize("header", ["{", "[]", json.dumps({"seed": 3}), json.dumps(7)])
def test_an_invalid_header_is_refused(header, tmp_path):
    path = tmp_path / "odd.npz"
    np.savez_compressed(path, header=np.array(header))
    with pytest.raises(ValueError, match="damaged, or no recording"):
        load(path)
