"""Tests of obedience: an instruction is judged by the motion, and the patient stays unchanged."""

import numpy as np
import pytest

from planner.correction import CORRECTIONS
from scenarios.bench.trials import obedience_trial
from scenarios.bench.trials.obedience_trial import (
    MIN_M,
    CorrectionResponse,
    ObedienceTrial,
    examine_obedience,
    is_obeyed,
    obedience_table,
)
from scenarios.bench.trials.run_trials import error_lines
from scenarios.catalogue import ORACLE
from scenarios.cli import main
from scenarios.demonstration.labels import THRESHOLD_RAD
from scenarios.loop.episode_config import EpisodeConfig

SEED = 10_001
HELD_BACK = [c for c in CORRECTIONS if c.text == "move right arm lower"]
DIRECTIONS = {"left": (1, 0, 0), "right": (-1, 0, 0), "higher": (0, 1, 0), "lower": (0, -1, 0)} | {
    "away": (0, 0, 1),
    "towards": (0, 0, -1),
}


@pytest.mark.parametrize("said", CORRECTIONS, ids=lambda c: c.text)
def test_it_is_obeyed_by_the_named_arm_in_the_named_way_far_enough(said):
    rows = {"left": [0], "right": [1], "both": [0, 1]}[said.arm]
    moved_m, opened_rad = np.zeros((2, 3)), np.zeros(2)
    if said.direction:
        moved_m[rows] = np.array(DIRECTIONS[said.direction]) * MIN_M
    else:
        opened_rad[rows] = THRESHOLD_RAD * (1 if said.jaw == "open" else -1)
    assert is_obeyed(said, 1.001 * moved_m, 1.001 * opened_rad)
    assert not is_obeyed(said, 0.999 * moved_m, 0.999 * opened_rad)
    assert not is_obeyed(said, -moved_m, -opened_rad)
    if said.arm != "both":
        assert not is_obeyed(said, moved_m[::-1], opened_rad[::-1])


def examined(controller, seed=SEED, by="planner"):
    config = EpisodeConfig(**ORACLE | {"controller": controller}, scenario="textbook")
    return examine_obedience(seed, config, by)


@pytest.fixture(scope="module")
def expert(made_once):
    return made_once("examined", lambda _: examined("expert"))


@pytest.mark.slow
def test_the_expert_obeys(expert):
    assert all(response.obeyed for response in expert.responses)
    assert expert.wrong_tube is True
    assert not any(response.withheld for response in expert.responses)
    assert len({response.text for response in expert.responses}) >= 13
    told = [response for response in expert.responses if response.told_m is not None]
    assert sum(response.right_distance for response in told) >= 0.95 * len(told)
    assert any(response.by_chance for response in expert.responses)


@pytest.mark.parametrize(
    ("moments", "said"),
    [(1, CORRECTIONS[:3]), pytest.param(4, CORRECTIONS, marks=pytest.mark.slow)],
)
@pytest.mark.slow
def test_the_idle_controller_does_not_obey(moments, said, monkeypatch):
    monkeypatch.setattr(obedience_trial, "MOMENTS", moments)
    monkeypatch.setattr(obedience_trial, "CORRECTIONS", said)
    trial = examined("idle")
    assert trial.responses
    assert not any(response.obeyed or response.withheld for response in trial.responses)
    assert trial.wrong_tube is None  # the idle arm never reaches a tube


def test_a_person_s_corrections_are_carried_out_under_a_controller_that_obeys_nothing(monkeypatch):
    monkeypatch.setattr(obedience_trial, "MOMENTS", 1)
    monkeypatch.setattr(obedience_trial, "CORRECTIONS", CORRECTIONS[:3])
    trial = examined("idle", by="person")  # without distances
    assert trial.responses
    assert all(response.obeyed for response in trial.responses)


@pytest.mark.parametrize("said", [HELD_BACK, pytest.param(CORRECTIONS, marks=pytest.mark.slow)])
def test_a_motion_that_the_safety_filter_held_differs_from_one_not_done(said, monkeypatch):
    monkeypatch.setattr(obedience_trial, "CORRECTIONS", said)
    monkeypatch.setattr(obedience_trial, "DISTANCE_STEPS", 1)  # they take time, and do not matter
    trial = examined("expert", 10_019)
    held = [response for response in trial.responses if not response.obeyed]
    assert held
    assert all(response.withheld for response in held)


@pytest.mark.slow
def test_asking_again_gives_the_same(expert):
    assert examined("expert") == expert


def test_the_table_counts_what_was_said_and_obeyed():
    text = CORRECTIONS[0].text
    responses = (
        CorrectionResponse(text=text, obeyed=True, by_chance=True, told_m=0.002, gone_m=0.0026),
        CorrectionResponse(text=text, obeyed=False, withheld=True, told_m=0.01, gone_m=0.0092),
    )
    table = obedience_table(
        [ObedienceTrial(seed=3, responses=responses, wrong_tube=True), ObedienceTrial(seed=4)]
    )
    rows = list(zip(*(column.cells for column in table.columns), strict=True))
    assert rows[0][:4] == (text, "2", "1", "1")
    assert rows[0][5] == "0.500"
    assert rows[1][1:] == ("0", "0", "0", "never said", "")
    assert rows[-3][1:4] == ("2", "1", "1")
    assert rows[-2][1:4] == ("2", "1", "")  # half a millimetre or a tenth
    assert rows[-1][1:4] == ("1", "1", "")


def test_a_trial_that_an_error_ended_is_named():
    trial = ObedienceTrial.lost(7, ValueError("no such patient"))
    (line,) = error_lines([ObedienceTrial(seed=6), trial])
    assert line.startswith("seed 7: ")
    assert "no such patient" in line


def test_a_checkpoint_that_is_not_there_is_one_line(tmp_path, capsys):
    assert main(["bench", "obedience", "--checkpoint", str(tmp_path / "none.safetensors")]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "--checkpoint" in line
