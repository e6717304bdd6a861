"""Tests of springs: force is the energy's slope, pulls balance, and overload breaks them."""

from collections.abc import Callable

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tissue_sim.bodies import dense_stiffness, forces
from tests.tissue_sim.verification.bodies import EPS, put, tissue_of
from tissue_sim.frames import Array
from tissue_sim.mechanics import springs
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.textbook import textbook_from_seed

NOISE_M = 3e-4
SEED = next(s for s in range(100) if textbook_from_seed(s).remnants >= 4)


@pytest.fixture(scope="module")
def tissue() -> Tissue:
    return tissue_of(build_organ(textbook_from_seed(SEED)), None)


@pytest.fixture
def whole(tissue: Tissue):
    """Yield the tissue with all springs intact, and restore it after the test."""
    before = tissue.state()
    yield tissue
    tissue.restore(before)


def spring_energy_j(tissue: Tissue) -> float:
    out = wp.zeros(1, dtype=wp.float64)
    wp.launch(springs.spring_energy, dim=1, inputs=[tissue.arrays, out])
    return float(out.numpy()[0])


def only(tissue: Tissue, kind: str) -> None:
    """Remove all springs but one kind."""
    for other in {"tie", "link", "anchor"} - {kind}:
        tissue.host(f"{other}_stiffness")[:] = 0.0


def disturbed(tissue: Tissue, seed: int = 0) -> Array:
    rest = tissue.organs[0].vertices
    return put(tissue, rest + np.random.default_rng(seed).normal(0, NOISE_M, rest.shape))


@pytest.mark.parametrize("kind", ["tie", "link", "anchor"])
def test_force_is_minus_the_slope_of_the_energy(whole: Tissue, kind: str) -> None:
    """Compare forces with central differences of the energy.

    Ties and anchors are quadratic: the difference is exact at any step. The strands are longer
    than a millimetre: (step / length)^2 is below 1e-4.
    """
    only(whole, kind)
    assert (whole.host(f"{kind}_stiffness") > 0).sum() >= 4
    x = disturbed(whole)
    f = forces(whole, "springs")
    rng = np.random.default_rng(1)
    step = 1e-5
    if kind == "link":
        ends = x[whole.organs[0].remnants]
        assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).min() > 100 * step
    for _ in range(10):
        d = np.where(np.abs(f) > 0, rng.normal(size=x.shape), 0.0)
        ahead, energy_ahead = put(whole, x + step * d), spring_energy_j(whole)
        behind, energy_behind = put(whole, x - step * d), spring_energy_j(whole)
        move = ahead - behind
        error = energy_ahead - energy_behind + (f * move).sum()
        # each spring's offset comes from coordinates of 0.1 m at most, rounded
        rounded = 8 * EPS * np.abs(x).max() * np.abs(f).sum()
        assert abs(error) < 1e-4 * np.linalg.norm(f) * np.linalg.norm(move) + rounded
        assert 10 * rounded < np.linalg.norm(f) * np.linalg.norm(move)


@pytest.mark.parametrize("kind", ["tie", "link"])
def test_springs_within_tissue_pull_both_ends_equally(whole: Tissue, kind: str) -> None:
    only(whole, kind)
    x = disturbed(whole)
    f = forces(whole, "springs")
    assert np.abs(f).max() > 1e-3
    rounding = 16 * EPS * np.abs(f).sum()
    assert np.abs(f.sum(axis=0)).max() < rounding
    # a tie pulls along its offset, which the coordinates round off
    lever = np.abs(x).max() + NOISE_M
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 8 * rounding * lever


@pytest.mark.parametrize("kind", ["tie", "anchor"])
def test_stiffness_is_the_curvature_of_the_energy(whole: Tissue, kind: str) -> None:
    """Check linear springs: f(x + d) - f(x) = -K d."""
    only(whole, kind)
    x = disturbed(whole)
    f = forces(whole, "springs")
    K = dense_stiffness(whole)
    assert np.abs(K - K.T).max() <= 2 * EPS * np.abs(K).max()
    moved = disturbed(whole, 1)
    change = forces(whole, "springs") - f
    stiffest = np.abs(K).sum(axis=1).max()
    error = change.ravel() + K @ (moved - x).ravel()
    assert np.abs(error).max() < 8 * EPS * stiffest * np.abs(x).max()


def pull_tie(tissue: Tissue, newtons: float) -> tuple[str, int]:
    stiffness = tissue.host("tie_stiffness")[0, 0]
    put(tissue, tissue.organs[0].vertices)
    offset = sum(
        w * tissue.positions()[v].astype(float)
        for v, w in zip(
            tissue.host("tie_corner")[0, 0], tissue.host("tie_weight")[0, 0], strict=True
        )
    )
    v = tissue.host("tie_corner")[0, 0, 0]
    tissue.positions()[v] += np.array([0, newtons / stiffness, 0]) - offset
    return "tie_stiffness", 0


def pull_link(tissue: Tissue, newtons: float) -> tuple[str, int]:
    i, j = tissue.host("link")[0, 0]
    tissue.host("link_stiffness")[0, 1:] = 0.0  # others that share an end
    stiffness, length = (tissue.host(n)[0, 0] for n in ("link_stiffness", "link_rest"))
    put(tissue, tissue.organs[0].vertices)
    x = tissue.positions()
    along = (x[j] - x[i]) / np.linalg.norm(x[j] - x[i])
    x[j] = x[i] + along * (length + newtons / stiffness)
    return "link_stiffness", 0


def pull_anchor(tissue: Tissue, newtons: float) -> tuple[str, int]:
    stiffness = tissue.host("anchor_stiffness")[0, 0]
    put(tissue, tissue.organs[0].vertices)
    point = tissue.host("anchor_point")[0, 0]
    tissue.positions()[tissue.host("anchor")[0, 0]] = point + np.array([0, 0, newtons / stiffness])
    return "anchor_stiffness", 0


PULLS = {"tie": pull_tie, "link": pull_link, "anchor": pull_anchor}


@pytest.mark.parametrize("kind", PULLS)
def test_a_spring_breaks_above_its_strength_and_not_below(tissue: Tissue, kind: str) -> None:
    # positions of 0.1 m are known to 1e-8 m: a millinewton for the stiffest, a tie of 400 N/m,
    # is 2.5e-6 m
    pull: Callable[[Tissue, float], tuple[str, int]] = PULLS[kind]
    strength = float(tissue.host(f"{kind}_strength")[0, 0])
    before = tissue.state()

    @settings(max_examples=25)
    @given(share=st.floats(0.0, 3.0).filter(lambda s: abs(s - 1) > 1e-3))
    def law(share: float) -> None:
        tissue.restore(before)
        name, row = pull(tissue, share * strength)
        tissue.stages["breakage"].launch()
        broken = tissue.host(name)[0, row] == 0.0
        assert broken == (share > 1)
        if kind != "link":
            others = np.delete(tissue.host(name)[0], row)
            np.testing.assert_array_equal(others, np.delete(before[name][0], row))

    try:
        law()
    finally:
        tissue.restore(before)


def test_a_broken_spring_has_no_force_and_stays_broken(whole: Tissue) -> None:
    only(whole, "anchor")
    pull_anchor(whole, 10.0)
    v = whole.host("anchor")[0, 0]
    assert np.linalg.norm(forces(whole, "springs")[v]) == pytest.approx(10.0, rel=1e-3)
    whole.stages["breakage"].launch()
    assert not forces(whole, "springs")[v].any()
    put(whole, whole.organs[0].vertices)
    whole.stages["breakage"].launch()
    assert whole.host("anchor_stiffness")[0, 0] == 0.0


def test_a_strand_does_not_break_when_pressed(whole: Tissue) -> None:
    pull_link(whole, -0.9 * whole.host("link_stiffness")[0, 0] * whole.host("link_rest")[0, 0])
    whole.stages["breakage"].launch()
    assert whole.host("link_stiffness")[0, 0] > 0
