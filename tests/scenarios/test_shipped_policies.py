"""The controller and the planner that come with Calot are found by default, and treat patients."""

import pytest

from controller.diffusion import checkpoint as of_controller
from planner.learned import checkpoint as of_planner
from scenarios.cli import main
from scenarios.loop.results import read_results


@pytest.mark.parametrize(
    ("shipped", "most_bytes"),
    [(of_controller.SHIPPED, 20_000_000), (of_planner.SHIPPED, 10_000_000)],
)
def test_they_are_small_enough_to_come_along(shipped, most_bytes):
    assert shipped.stat().st_size <= most_bytes


@pytest.mark.parametrize("planner", ["scripted", "learned"])
def test_they_treat_two_of_three_patients_or_all(tmp_path, planner):
    words = ["--seed", "10004", "--episodes", "3", "--controller", "diffusion"]
    assert main(["run", *words, "--planner", planner, "--out", str(tmp_path)]) in (0, 1)
    episodes = read_results(tmp_path / "results.json")
    assert all(episode.error is None for episode in episodes)
    assert sum(episode.success for episode in episodes) >= 2
