"""Tests of what comes with Calot: by default it operates; of another world, it is refused."""

import json
from pathlib import Path

import pytest
from safetensors import safe_open
from safetensors.torch import load_file, save_file

from controller.diffusion import policy as of_controller
from controller.perception import checkpoint as of_perception
from planner.learned import network as of_planner
from scenarios.catalogue import ORACLE
from scenarios.cli import main
from scenarios.commands.policy_options import say_who_acts
from scenarios.loop.episode_config import EpisodeConfig
from tests.scenarios.example_results import read_results
from tissue_sim.constants import WORLD_VERSION

MOST_BYTES = 20_000_000
SHIPPED = {
    "--planner-checkpoint": (of_planner.CHECKPOINTS.shipped, ["--planner", "learned"]),
    "--checkpoint": (of_controller.CHECKPOINTS.shipped, ["--controller", "diffusion"]),
    "--perception-checkpoint": (of_perception.CHECKPOINTS.shipped, ["--sense", "cameras"]),
}
OPERABLE = 10_707  # a tuning patient


@pytest.mark.parametrize("option", SHIPPED)
def test_their_files_are_small_enough_to_be_shipped(option):
    assert SHIPPED[option][0].stat().st_size <= MOST_BYTES


@pytest.mark.parametrize("option", SHIPPED)
def test_of_another_world_they_are_refused_in_one_line(option, tmp_path, capsys):
    shipped, words = SHIPPED[option]
    other = of_another_world(shipped, tmp_path / "other.safetensors")
    assert main(["run", *words, option, str(other)]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.count("\n") == 1
    assert f"world version {WORLD_VERSION - 1}, but here it is {WORLD_VERSION}" in err


def test_by_default_planner_and_controller_do_most_of_a_procedure(tmp_path):
    assert main(["run", "--seed", str(OPERABLE), "--out", str(tmp_path)]) in (0, 1)
    (episode,) = read_results(tmp_path / "results.json")
    assert episode.error is None
    assert episode.sense == "tracked"
    assert sum(task.success for task in episode.tasks) >= 9


def test_without_a_choice_nobody_is_privileged(capsys):
    say_who_acts(EpisodeConfig().planner, EpisodeConfig().controller, EpisodeConfig().sense)
    said = capsys.readouterr().err
    assert "planner: learned; controller: diffusion\n" in said
    assert "sense: tracked: " in said


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
