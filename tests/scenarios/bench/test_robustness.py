"""Tests of the storms and of their report."""

import re
from itertools import islice

import numpy as np
import pytest

from scenarios.bench.trials.run_trials import TrialAttempt
from scenarios.bench.trials.storm import MAX_SPEED_M_S, storm
from scenarios.bench.trials.storm_trial import (
    StormTrial,
    broken_lines,
    intact,
    run_trial,
    trial_on,
    trial_table,
)
from scenarios.cli import main
from tests.tissue_sim.patients import cut_at
from tests.worlds import textbook_world
from tissue_sim.frames import Array
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.organ import PARTS, TUBES
from tissue_sim.tools.arms import JointCommand
from tissue_sim.tools.psm import forward_kinematics
from tissue_sim.world import World

SEED = 10_016
STORMS = 10  # some of them clip, cut or tear


@pytest.fixture(scope="module")
def trials() -> list[StormTrial]:
    return [run_trial(SEED + k) for k in range(STORMS)]


@pytest.mark.slow
def test_storms_break_no_law(trials: list[StormTrial]) -> None:
    assert broken_lines(trials) == []


@pytest.mark.parametrize("seed", [10_004, 10_060])
def test_the_filling_beside_a_clip_on_the_gallbladder_unfolds(seed: int) -> None:
    trial = run_trial(seed)
    assert trial.clipped
    assert trial.broken == ()


@pytest.mark.parametrize("tube", TUBES)
def test_a_piece_that_is_cut_free_does_not_fly_off(tube: str) -> None:
    """Cut a tube twice before the storm: only inertia resists the piece's rigid motion."""
    world = textbook_world(SEED)
    for share in (0.3, 0.7):
        assert cut_at(world.tubes, tube, share * world.tubes.length_m[tube])
    piece = ~intact(world) & (world.tissue.host("tet_alive")[0, : len(world.organ.region)] != 0)
    assert piece.sum() > 50
    assert trial_on(world, SEED).broken == ()


@pytest.mark.slow
def test_a_storm_is_violent(trials: list[StormTrial]) -> None:
    assert all(t.touched for t in trials)
    assert np.median([t.tip_speed_m_s for t in trials]) == pytest.approx(MAX_SPEED_M_S, rel=0.1)
    assert sum(t.inverted > 20 for t in trials) >= 3
    assert any(t.clipped or t.cut for t in trials)
    assert any(t.torn for t in trials)
    assert max(t.commanded_speed_m_s for t in trials) < MAX_SPEED_M_S * (1 + 1e-6)


def tips(world: World, command: JointCommand) -> Array:
    """Return the commanded tips, (2, 3)."""
    rows = zip(world.arms.T_world_rcm, command.joints, world.arms.mounted, strict=True)
    return np.stack([(T @ forward_kinematics(q[:6], tool))[:3, 3] for T, q, tool in rows])


def test_a_storm_is_determined_by_its_seed_and_its_speed_is_bounded() -> None:
    paths = []
    for _ in range(2):
        world = textbook_world(SEED)
        path = []
        for command in islice(storm(world, SEED), 60):
            path.append((tips(world, command), world.arms.mounted[1].name))
            world.step(command)
        paths.append(path)
    for (a, _), (b, _) in zip(*paths, strict=True):
        np.testing.assert_array_equal(a, b)
    most_m = MAX_SPEED_M_S * world.config.control_step_s
    for (before, tool), (after, same) in zip(paths[0][:-1], paths[0][1:], strict=True):
        if tool == same:
            assert np.linalg.norm(after - before, axis=1).max() < most_m * (1 + 1e-6)


def test_tissue_that_is_detached_from_the_body_is_not_intact() -> None:
    world = textbook_world(SEED)
    region, tissue = world.organ.region, world.tissue
    assert intact(world).all()
    tissue.host("fixed")[0, world.organ.sac_rings[-1]] = 0  # the fundus
    assert intact(world).all()
    tissue.host("anchor_stiffness")[:] = 0.0
    assert intact(world).all()  # the tubes still hold the sac
    tissue.host("tie_stiffness")[:] = 0.0
    at_risk = [2 * PARTS.index(trunk) for trunk in AT_RISK]
    np.testing.assert_array_equal(intact(world), region >= min(at_risk))
    tissue.host("fixed")[0, world.organ.sac_rings[-1]] = 1
    of_sac = region // 2 == PARTS.index("gallbladder")
    np.testing.assert_array_equal(intact(world), of_sac | (region >= min(at_risk)))


def test_an_exception_is_a_broken_law() -> None:
    lost = TrialAttempt(run=run_trial, kind=StormTrial)(-1)
    (said,) = lost.broken
    assert said.startswith("ValueError")
    assert re.search(r"\.py:\d+\)$", said)  # where it was raised
    assert broken_lines([lost]) == [f"seed -1: {said}"]
    assert trial_table([lost]).row_count > 0


def test_the_command_reports_and_sets_its_exit_code(capsys) -> None:
    assert main(["bench", "robustness", "--episodes", "1"]) == 0
    said = capsys.readouterr().out
    for words in ("1 storms", "tip speed", "broke a law", "load"):
        assert words in said
