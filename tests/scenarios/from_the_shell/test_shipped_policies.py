"""Tests of what comes with Calot: it operates; a missing or another world's file is refused."""

import json
from pathlib import Path

import pytest
from safetensors import safe_open
from safetensors.torch import load_file, save_file

from scenarios.catalogue import ORACLE
from scenarios.cli import main
from scenarios.commands.policy_options import say_who_acts
from scenarios.loop.episode_config import EpisodeConfig
from tests.scenarios.example_results import read_results
from tests.stand_ins import LEARNERS, needs_trained
from tissue_sim.constants import WORLD_VERSION

MOST_BYTES = 20_000_000
USES = {
    "planner": ["--planner", "learned"],
    "controller": ["--controller", "diffusion"],
    "perception": ["--sense", "cameras"],
}
OPTIONS = {
    "planner": "--planner-checkpoint",
    "controller": "--checkpoint",
    "perception": "--perception-checkpoint",
}
OPERABLE = 10_707  # a tuning patient
LEARNED_BY_DEFAULT = EpisodeConfig().planner == "learned"


@pytest.mark.parametrize("learner", LEARNERS)
def test_their_files_are_small_enough_to_be_shipped(learner):
    """Check the shipped file, or until there is one an untrained network of the same sizes."""
    assert LEARNERS[learner].shipped.stat().st_size <= MOST_BYTES


@pytest.mark.parametrize("learner", LEARNERS)
def test_of_another_world_they_are_refused_in_one_line(learner, tmp_path, capsys):
    other = of_another_world(LEARNERS[learner].shipped, tmp_path / "other.safetensors")
    assert main(["run", *USES[learner], OPTIONS[learner], str(other)]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.count("\n") == 1
    assert f"world version {WORLD_VERSION - 1}, but here it is {WORLD_VERSION}" in err


@pytest.mark.parametrize("learner", LEARNERS)
def test_where_none_is_shipped_one_line_says_how_to_make_one(learner, tmp_path, capsys):
    learner_of, missing = LEARNERS[learner], tmp_path / "none.safetensors"
    stand_in = learner_of.shipped
    object.__setattr__(learner_of, "shipped", missing)
    try:
        assert main(["run", *USES[learner]]) == 2
    finally:
        object.__setattr__(learner_of, "shipped", stand_in)
    out, err = capsys.readouterr()
    assert not out
    none = f"none of world version {WORLD_VERSION} comes with Calot"
    made = f"`calot train {learner}` makes one to name"
    assert err == f"calot: {OPTIONS[learner]}: {none}: {made}\n"


def test_by_default_a_procedure_passes(ran_by_command):
    out, ended = ran_by_command
    assert ended.returncode == 0
    (episode,) = read_results(out / "results.json")
    assert episode.outcome == "passed"
    assert (episode.planner, episode.controller, episode.sense) == tuple(ORACLE.values())


@needs_trained
def test_learned_planner_and_controller_do_most_of_a_procedure(tmp_path):
    words = ["run", *USES["planner"], *USES["controller"], "--seed", str(OPERABLE)]
    assert main([*words, "--out", str(tmp_path)]) in (0, 1)
    (episode,) = read_results(tmp_path / "results.json")
    assert episode.error is None
    assert episode.sense == "tracked"
    assert sum(task.success for task in episode.tasks) >= 9


@pytest.mark.skipif(not LEARNED_BY_DEFAULT, reason="the oracle is the default")
def test_without_a_choice_nobody_is_privileged(capsys):
    said = said_by_default(capsys)
    assert "planner: learned; controller: diffusion\n" in said
    assert "sense: tracked: " in said


@pytest.mark.skipif(LEARNED_BY_DEFAULT, reason="learned policies are the default")
def test_defaults_that_are_privileged_say_so(capsys):
    said = said_by_default(capsys)
    assert "planner: scripted (privileged" in said
    assert "controller: expert (privileged" in said
    assert "sense: tracked: " in said


def said_by_default(capsys: pytest.CaptureFixture[str]) -> str:
    say_who_acts(EpisodeConfig().planner, EpisodeConfig().controller, EpisodeConfig().sense)
    return capsys.readouterr().err


def test_the_oracle_says_that_it_is_privileged(capsys):
    say_who_acts(**ORACLE)
    said = capsys.readouterr().err
    assert "planner: scripted (privileged" in said
    assert "controller: expert (privileged" in said
    assert "sense: exact: simulator state, which no robot has" in said


def of_another_world(shipped: Path, path: Path) -> Path:
    """Write a copy of a checkpoint that says that it is of the world before this one."""
    with safe_open(shipped, "pt") as file:
        said = file.metadata()
    fits = json.loads(said["fits"]) | {"world version": WORLD_VERSION - 1}
    save_file(load_file(shipped), path, said | {"fits": json.dumps(fits)})
    return path
