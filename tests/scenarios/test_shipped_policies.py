"""Tests of the shipped controller and planner: found by default, and able to treat patients."""

import pytest

from controller.diffusion import checkpoint as of_controller
from planner.learned import checkpoint as of_planner
from scenarios.cli import main
from scenarios.loop.results import read_results


@pytest.mark.parametrize(
    ("shipped", "most_bytes"),
    [(of_controller.SHIPPED, 20_000_000), (of_planner.SHIPPED, 10_000_000)],
)
def test_their_files_are_small_enough_to_be_shipped(shipped, most_bytes):
    assert shipped.stat().st_size <= most_bytes


def treated(out, *words):
    """Return whether each patient is treated with success by the shipped controller."""
    assert main(["run", "--controller", "diffusion", *words, "--out", str(out)]) in (0, 1)
    episodes = read_results(out / "results.json")
    assert all(episode.error is None for episode in episodes)
    return [episode.success for episode in episodes]


def test_together_they_treat_a_patient(tmp_path):
    assert treated(tmp_path, "--planner", "learned", "--seed", "10400") == [True]


@pytest.mark.slow
@pytest.mark.parametrize("planner", ["scripted", "learned"])
def test_they_treat_two_of_three_patients_or_all(tmp_path, planner):
    words = ["--planner", planner, "--seed", "10004", "--episodes", "3"]
    assert sum(treated(tmp_path, *words)) >= 2
