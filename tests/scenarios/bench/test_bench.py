"""Tests of the stopwatch and of the benches: times add up, and timing changes nothing."""

import re
from contextlib import nullcontext
from importlib.metadata import PackageNotFoundError
from itertools import islice

import numpy as np
import pytest

from scenarios.bench.newton_solver import CONVERGED, STEPS, bench_newton, race
from scenarios.bench.stopwatch import REST, Stopwatch
from scenarios.bench.trials.newton_retraction import (
    DRAWN_STEPS,
    RETRACTION_M,
    Solver,
    body_of,
    in_calot,
    in_newton,
)
from scenarios.bench.world import watch_step
from scenarios.catalogue import WITNESS
from scenarios.cli import main
from scenarios.files.outside_text import Terminal
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tissue_sim.frames import UP
from tissue_sim.mechanics.tissue import TissueConfig
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.organ import TUBES


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
        episode = begin(EpisodeConfig(**WITNESS, scenario="textbook", seed=10_004))
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
        " obedience, planner, corrections, distances, latency, viewer, language, population,"
        " faults\n"
    )


def test_the_report_says_the_speed_and_what_was_measured(capsys):
    assert main(["bench", "world", "--seed", "10004", "--steps", "5"]) == 0
    said = capsys.readouterr().out
    assert "5 control steps" in said
    for word in ("tissue: elements", "arms: PhysX", "events and injuries", "observe", "whole step"):
        assert word in said
    for words in ("times real time", "tetrahedra", "vertices", "cores", "load", "Newton"):
        assert words in said


def test_the_language_report_times_grammar_and_encoder(capsys):
    assert main(["bench", "language", "--repeats", "1"]) == 0
    said = capsys.readouterr().out
    assert "grammar" in said
    assert "heads" in said


def test_without_newton_one_line_says_how_to_install_it(monkeypatch):
    def not_installed(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr("scenarios.bench.newton_solver.version", not_installed)
    console = Terminal(width=200)
    with console.capture() as capture:
        console.print(bench_newton(seed=10_004))
    assert capture.get().splitlines() == [
        "Newton is not installed; to compare with it: .venv/bin/pip install -e '.[newton]'"
    ]


def test_the_solvers_alternate_and_each_is_retracted_and_held():
    heard = []
    solvers = [
        Solver(
            name=name,
            step=lambda before, after, name=name: heard.append((name, before, after)),
            positions=lambda: np.zeros((0, 3)),
        )
        for name in ("a", "b")
    ]
    times_ms = race(solvers, DRAWN_STEPS + 2)
    assert times_ms.shape == (2, DRAWN_STEPS + 2)
    assert (times_ms > 0).all()
    assert [name for name, _, _ in heard] == ["a", "b"] * (DRAWN_STEPS + 2)
    befores, afters = np.array([motion for name, *motion in heard if name == "b"]).T
    np.testing.assert_array_equal(befores[1:], afters[:-1])
    assert befores[0] == 0.0
    np.testing.assert_allclose(afters[-3:], RETRACTION_M)
    assert np.ptp(np.diff(afters[:DRAWN_STEPS])) < 1e-12


@pytest.fixture(scope="module")
def body():
    return body_of(anatomy_from_seed(10_004))


@pytest.fixture(scope="module")
def retracted(body):
    """Return the tissue's vertices after it is retracted and held."""
    solver = in_calot(body, TissueConfig())
    race([solver], STEPS)
    return solver.positions()


def test_held_vertices_stay_and_drawn_ones_go_up(body, retracted):
    moved = retracted - body.organ.vertices
    still = body.held.copy()
    still[body.drawn] = False
    assert np.abs(moved[still]).max() < 1e-8
    np.testing.assert_allclose(
        moved[body.drawn], np.tile(RETRACTION_M * UP, (len(body.drawn), 1)), atol=1e-8
    )
    for tube in TUBES:  # the springs pull both tubes along, as far as their walls give
        upper = body.organ.rings[tube][body.organ.neck_ring[tube] // 2]
        assert (moved[upper] @ UP > 0.15 * RETRACTION_M).all()


def test_the_tissue_comes_to_rest_near_the_converged_solution(body, retracted):
    """Check that every vertex is within 0.1 mm of the converged solution."""
    converged = in_calot(body, CONVERGED)
    race([converged], STEPS)
    assert np.linalg.norm(retracted - converged.positions(), axis=1).max() < 1e-4


def test_newton_holds_the_same_body(body):
    pytest.importorskip("newton")
    ours, newtons = in_calot(body, TissueConfig()), in_newton(body, substeps=20, iterations=10)
    np.testing.assert_allclose(newtons.positions(), ours.positions(), atol=1e-8)
    race([ours, newtons], 10)
    np.testing.assert_allclose(
        newtons.positions()[body.held], ours.positions()[body.held], atol=1e-7
    )
    apart = np.linalg.norm(newtons.positions() - ours.positions(), axis=1)
    assert np.median(apart) < 0.002


@pytest.mark.slow
def test_the_accuracy_report_ends_below_the_allowed_error(capsys):
    assert main(["bench", "accuracy", "--seed", "10003", "--steps", "30"]) == 0
    said = capsys.readouterr().out
    assert "3276" in said
    assert "13104" in said
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
