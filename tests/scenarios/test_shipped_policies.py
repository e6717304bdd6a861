"""Tests of the shipped controller and planner: of another world, they are refused in one line."""

import pytest

from controller.diffusion import checkpoint as of_controller
from planner.learned import checkpoint as of_planner
from scenarios.cli import main
from scenarios.commands.policy_option import say_who_acts
from scenarios.loop.episode_config import EpisodeConfig


@pytest.mark.parametrize(
    ("shipped", "most_bytes"),
    [(of_controller.SHIPPED, 20_000_000), (of_planner.SHIPPED, 10_000_000)],
)
def test_their_files_are_small_enough_to_be_shipped(shipped, most_bytes):
    assert shipped.stat().st_size <= most_bytes


@pytest.mark.parametrize("words", [["--planner", "learned"], ["--controller", "diffusion"]])
def test_trained_on_another_world_they_are_refused_in_one_line(words, capsys):
    assert main(["run", *words]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.count("\n") == 1
    assert "world version 5, but here it is 6" in err


def test_without_a_choice_the_witness_acts_and_says_so(capsys):
    say_who_acts(EpisodeConfig().planner, EpisodeConfig().controller, EpisodeConfig().sense)
    said = capsys.readouterr().err
    assert "planner: scripted (privileged" in said
    assert "controller: expert (privileged" in said
    assert "sense: exact: simulator state, which no robot has" in said
