"""The diffusion controller that comes with Calot is found by default, and treats patients."""

from controller.diffusion.checkpoint import SHIPPED
from scenarios.cli import main
from scenarios.results import read_results

MOST_BYTES = 20_000_000


def test_it_is_small_enough_to_come_along():
    assert SHIPPED.stat().st_size <= MOST_BYTES


def test_it_treats_two_of_three_patients_or_all(tmp_path):
    words = ["--seed", "10004", "--episodes", "3", "--controller", "diffusion"]
    assert main(["run", *words, "--out", str(tmp_path)]) in (0, 1)
    episodes = read_results(tmp_path / "results.json")
    assert all(episode.error is None for episode in episodes)
    assert sum(episode.success for episode in episodes) >= 2
