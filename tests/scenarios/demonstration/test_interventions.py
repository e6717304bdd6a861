"""Tests of interventions: the dataset loads, and only what a person said is flagged in it."""

import json
from dataclasses import replace
from itertools import groupby, islice

import numpy as np
import pytest

from controller.correction import SPEED_M_S
from controller.dataset.part import part_bytes, read_part
from controller.dataset.reader import read_episodes
from planner.person.orders import DEFAULT_M
from scenarios.catalogue import ORACLE
from scenarios.cli import main
from scenarios.demonstration.interventions import Interventions
from scenarios.demonstration.mix import KINDS
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.inbox import Inbox
from scenarios.loop.person.script import Timed
from scenarios.recording.attempt import attempt_episode
from scenarios.recording.recorder import load
from scenarios.run_episode import begin
from tests.controller.dataset.episodes import random_episode, write_parts
from tests.scenarios.calling import UNSURE

SEED = 9_004
HIGHER = "move right arm higher"
SAID = f"1\t{HIGHER}\n2.5\tresume\n4\tstop\n4.5\tresume\n20\tnext step\n21\tyes\n30\twhat a day\n"


@pytest.fixture(scope="module")
def spoken(tmp_path_factory):
    """Return the result, recording and dataset of a procedure in which a person speaks."""
    out = tmp_path_factory.mktemp("spoken")
    (out / "said.tsv").write_text(SAID)
    config = EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED, instruct=str(out / "said.tsv"))
    result = attempt_episode(config, out, [Interventions(out / "set", config)]).result
    (episode,) = read_episodes(out / "set")
    return result, load(out / "episodes" / f"{SEED}.npz"), episode


@pytest.mark.slow
def test_a_procedure_passes_though_a_person_skips_a_task_and_makes_it_wait(spoken):
    result, recording, _ = spoken
    assert result.success, [task for task in result.tasks if not task.success]
    assert (result.corrections, result.tasks[0].corrections) == (1, 1)
    assert [line["text"] for line in recording.heard] == [
        line.split("\t")[1] for line in SAID.splitlines()
    ]
    assert recording.heard[-1]["instruction"] is None


@pytest.mark.slow
def test_it_loads_as_an_episode_with_the_correction_flagged_where_it_was_in_force(spoken):
    result, recording, episode = spoken
    assert (episode.header.kind, episode.header.seed) == ("intervention", SEED)
    assert episode.header.success == result.success
    flags, corrections = episode.columns["flag"], episode.columns["correction"]
    texts = [recording.instructions[row]["text"] for row in recording.arrays["instruction"]]
    assert flags.sum() == texts.count(HIGHER) >= 30 * DEFAULT_M / SPEED_M_S
    assert set(corrections[flags]) == {HIGHER}
    assert set(corrections[~flags]) == {""}
    assert set(episode.columns["instruction"][flags]) == {HIGHER}
    exchanging = round(30 * result.exchange_time_s)
    last = len(texts) - 1 - texts[::-1].index(HIGHER)
    stays = round(30 * 2.5) - (last + 1)  # until "resume"
    assert len(episode) == len(texts) - texts.count("hold") - exchanging - stays


@pytest.mark.slow
def test_nothing_to_imitate_lies_across_a_hold(spoken):
    _, _, episode = spoken
    moved = np.diff(episode.columns["segment"])
    assert moved.min() == 0
    n_exchanges = 3 + 1 + 3
    assert episode.columns["segment"].max() == n_exchanges + 2  # the hold, and the arm that stayed


def watched(out, *said, expert=True, n=60):
    """Save the first n steps of an episode as a dataset; return what `save` returns."""
    inbox = Inbox()
    inbox.arrange([Timed(time_s=time_s, text=text) for time_s, text in said])
    config = EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED)
    interventions = Interventions(out, config if expert else replace(config, controller="idle"))
    episode = begin(config, inbox=inbox)
    interventions.on_reset(episode.world)
    for step in islice(episode.steps(), n):
        interventions.on_step(step)
    return interventions.save(False, ["still going on"])


@pytest.mark.parametrize("said", [(), ((0.5, "stop"),), ((0.5, "what a day"),)])
def test_nothing_is_saved_if_no_instruction_was_obeyed(tmp_path, said):
    assert watched(tmp_path / "set", *said) is None
    assert not (tmp_path / "set").exists()


def test_a_dataset_grows_by_each_and_a_learned_controller_is_not_imitated(tmp_path):
    paths = [watched(tmp_path, (0.5, HIGHER), expert=expert) for expert in (True, False)]
    assert len(set(paths)) == 2
    one, other = read_episodes(tmp_path)
    assert [len(e.stretches()) for e in (one, other)] == [1, 0]
    runs = [(flag, len(list(g))) for flag, g in groupby(one.columns["flag"])]
    assert runs[0] == (False, 15)
    assert runs[1][0]
    assert runs[1][1] >= 30 * DEFAULT_M / SPEED_M_S


def test_it_tells_by_which_sense_and_checkpoints_it_is(tmp_path):
    read = read_part(watched(tmp_path, (0.2, HIGHER), n=10))
    assert (read.header.sense, read.header.checkpoints) == ("exact", {})
    assert read.header.kind in KINDS
    assert read.header.scenario == "textbook"


def run_with_a_word(tmp_path):
    """Run an episode in which a person speaks, into the dataset `set`; return its exit code."""
    (tmp_path / "said.tsv").write_text(f"0.3\t{HIGHER}\n")
    words = ["--planner", "tests.scenarios.calling:PlannerCallsLater", "--controller", "expert"]
    words += ["--seed", "3", "--instruct", str(tmp_path / "said.tsv")]
    words += ["--save-interventions", str(tmp_path / "set"), "--out", str(tmp_path / "out")]
    return main(["run", *words])


def test_an_intervention_that_cannot_be_saved_is_one_line_and_the_outcome_stays(tmp_path, capfd):
    (damaged,) = write_parts(tmp_path / "set" / "parts", (7,))
    content = bytearray(damaged.read_bytes())
    content[100:110] = bytes(10)
    damaged.write_bytes(content)
    assert run_with_a_word(tmp_path) == 2
    out, err = capfd.readouterr()
    line = err.splitlines()[-1]
    assert line.startswith(f"calot: --save-interventions: cannot save that of seed 3: {damaged}: ")
    (episode,) = json.loads((tmp_path / "out" / "results.json").read_text())["episodes"]
    assert (episode["error"], episode["call"]["reason"]) == (None, UNSURE)
    assert UNSURE in out


@pytest.mark.parametrize(
    ("header", "why"),
    [
        ({"cameras": ("wrist_left",)}, "was filmed"),
        ({"sense": "exact"}, "is of the sense exact, these of tracked"),
        ({"world_version": 1}, "its world is version 1"),
    ],
)
def test_a_folder_that_interventions_cannot_join_is_refused_before_anything_runs(
    tmp_path, capfd, header, why
):
    episode = random_episode(7, cameras=header.get("cameras", ()))
    episode = replace(episode, header=replace(episode.header, **header))
    part = tmp_path / "set" / "parts" / "00007-nominal.parquet"
    part.parent.mkdir(parents=True)
    part.write_bytes(part_bytes(episode))
    assert run_with_a_word(tmp_path) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert str(part) in line
    assert why in line
    assert not (tmp_path / "out").exists()


def test_a_save_takes_a_name_that_is_free_though_an_earlier_part_was_deleted(tmp_path):
    first, second = (watched(tmp_path, (0.2, HIGHER), n=10) for _ in range(2))
    kept = second.read_bytes()
    first.unlink()
    third = watched(tmp_path, (0.2, HIGHER), n=20)
    assert third != second
    assert second.read_bytes() == kept
    assert sorted(map(len, read_episodes(tmp_path))) == [10, 20]


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--seed", "9999", "--episodes", "2"], "training seeds"),
        (["--workers", "2"], "workers 1"),
    ],
)
def test_test_patients_are_not_trained_on(capfd, tmp_path, words, why):
    assert main(["run", *words, "--save-interventions", str(tmp_path / "set")]) == 2
    assert why in capfd.readouterr().err
    assert not (tmp_path / "set").exists()
