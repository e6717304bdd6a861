"""Tests of the stopwatch and of the benches: times add up, and timing changes nothing."""

import re
from contextlib import nullcontext
from itertools import islice

import numpy as np
import pytest

from scenarios.bench.stopwatch import REST, Stopwatch
from scenarios.bench.world import watch_step
from scenarios.catalogue import ORACLE
from scenarios.cli import main
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin


class Kitchen:
    """Cooks for 6 s on a fake clock: 1 s itself, 2 s stirring, 3 s heating inside stirring."""

    def __init__(self):
        self.time_s = 0.0

    def cook(self, dish):
        self.time_s += 1.0
        self.stir()
        return f"hot {dish}"

    def stir(self):
        self.time_s += 2.0
        self.heat()

    def heat(self):
        self.time_s += 3.0


@pytest.fixture
def kitchen(monkeypatch):
    kitchen = Kitchen()
    monkeypatch.setattr("scenarios.bench.stopwatch.perf_counter", lambda: kitchen.time_s)
    return kitchen


@pytest.fixture
def stopwatch(kitchen):
    stopwatch = Stopwatch(kitchen, "cook")
    stopwatch.stage(kitchen, "stir", "stir")
    stopwatch.stage(kitchen, "heat", "heat")
    return stopwatch


def test_a_stage_is_timed_without_the_stages_inside_it(kitchen, stopwatch):
    assert kitchen.cook("soup") == "hot soup"
    assert stopwatch.stages_s == [{"stir": 2.0, "heat": 3.0, REST: 1.0}]
    assert stopwatch.whole_s == [6.0]


def test_stages_are_counted_only_inside_calls_of_the_function(kitchen, stopwatch):
    kitchen.heat()
    kitchen.cook("soup")
    kitchen.heat()
    kitchen.cook("rice")
    assert stopwatch.whole_s == [6.0, 6.0]
    assert [stages["heat"] for stages in stopwatch.stages_s] == [3.0, 3.0]


def test_the_functions_are_restored(kitchen, stopwatch):
    with stopwatch:
        kitchen.cook("soup")
    kitchen.cook("rice")
    assert len(stopwatch.whole_s) == 1


def test_timing_the_world_does_not_change_it():
    def run(*, timed):
        episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=10_004))
        steps = islice(episode.steps(), 90)
        with watch_step(episode.world) if timed else nullcontext() as stopwatch:
            for _ in steps:
                pass
        return episode.world.tissue.state(), episode.observation.vector(), stopwatch

    (tissue, seen, _), (tissue_timed, seen_timed, stopwatch) = run(timed=False), run(timed=True)
    np.testing.assert_array_equal(seen, seen_timed)
    for name, array in tissue.items():
        np.testing.assert_array_equal(array, tissue_timed[name])
    assert stopwatch is not None
    assert len(stopwatch.whole_s) == 90
    assert all(spent_s > 0 for stages in stopwatch.stages_s for spent_s in stages.values())
    shares = [
        sum(stages.values()) / whole_s
        for stages, whole_s in zip(stopwatch.stages_s, stopwatch.whole_s, strict=True)
    ]
    assert np.median(shares) == pytest.approx(1.0, abs=0.01)  # the stopwatch itself takes the rest


def test_an_unknown_bench_is_one_line_with_the_allowed_names(capfd):
    assert main(["bench", "wrld"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err == (
        "calot: Unrecognized options: wrld;"
        " Available subcommands: world, stack, accuracy, robustness, parallel, safety, controller,"
        " obedience, planner, corrections, what-if, distances, population, faults\n"
    )


def test_the_report_says_the_speed_and_what_was_measured(capsys):
    assert main(["bench", "world", "--seed", "10004", "--steps", "5"]) == 0
    said = capsys.readouterr().out
    assert "5 control steps" in said
    for word in ("tissue: elements", "arms: PhysX", "events and injuries", "observe", "whole step"):
        assert word in said
    for words in ("times real time", "tetrahedra", "vertices", "cores", "load"):
        assert words in said


@pytest.mark.slow
def test_the_accuracy_report_ends_below_the_allowed_error(capsys):
    assert main(["bench", "accuracy", "--seed", "10003", "--steps", "30"]) == 0
    said = capsys.readouterr().out
    usual, fine = sorted({int(n) for n in re.findall(r"│ +(\d{4,5}) │", said)})
    assert fine == 4 * usual
    at_rest = re.search(r"at rest: (\S+) mm at most, allowed (\S+) mm", said)
    assert at_rest
    assert float(at_rest[1]) < float(at_rest[2])


def test_a_patient_whose_tubes_touch_is_refused_in_one_line(capsys):
    assert main(["bench", "accuracy", "--seed", "10000", "--steps", "1"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "Traceback" not in said.err
    last = said.err.splitlines()[-1]
    assert last.startswith("calot: --seed 10000: a tube touches another one or the gallbladder")
