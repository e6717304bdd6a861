"""Tests of bodies against closed forms: a stretched bar, a bent beam, and several blocks.

The experiments are those of the validation page, `notebooks/01_field_and_physics.ipynb`.
"""

import numpy as np
import pytest

from tests.tissue_sim.verification.bodies import EPS, SETTLED_M, box, face_share, overdamped, settle
from tests.tissue_sim.verification.cantilever import (
    LENGTH_M,
    LOADINGS,
    WIDTH_M,
    cantilever,
    timoshenko_m,
)
from tests.tissue_sim.verification.clip_closure import squeezed_block
from tests.tissue_sim.verification.cut_strip import slit, whole_cut
from tests.tissue_sim.verification.friction_cone import FRICTION_ERROR, friction_cone
from tests.tissue_sim.verification.stretch import stretch
from tests.tissue_sim.verification.tented import tented
from tests.tissue_sim.verification.volume import volume
from tissue_sim.patient.material import Material


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45])
def test_a_pulled_bar_stretches_as_its_energy_predicts(poisson: float) -> None:
    bar = stretch(poisson, [0.02, 0.3])
    np.testing.assert_allclose(bar.measured, bar.expected[:, [0, 1, 1]], atol=bar.tolerance)
    assert bar.uneven.max() < bar.tolerance


def test_a_wall_with_collagen_stiffens_as_its_energy_predicts() -> None:
    soft, wall = (stretch(0.45, [0.1, 0.5, 1.5], c) for c in (0.0, 8.0))
    np.testing.assert_allclose(wall.measured, wall.expected[:, [0, 1, 1]], atol=wall.tolerance)
    assert wall.uneven.max() < wall.tolerance
    drawn = wall.measured[:, 0] - 1
    assert np.all(drawn < soft.measured[:, 0] - 1)
    secant = wall.stress_over_young / drawn
    assert np.all(np.diff(secant) > 0.25)  # the further, the stiffer
    assert secant[0] == pytest.approx(
        soft.stress_over_young[0] / (soft.measured[0, 0] - 1), rel=0.1
    )


def test_a_tube_drawn_out_of_its_bed_rises_as_a_beam_on_a_foundation() -> None:
    """Check that the lift converges from below to the closed form."""
    duct = tented()
    assert duct.expected_m < 0.1 * WIDTH_M  # small enough for a linear theory
    assert np.all(np.diff(duct.lifted_m) > 0)
    assert np.all((duct.excess > 0) & (duct.excess < duct.max_excess))
    assert duct.excess[-1] < 0.06


@pytest.mark.parametrize("stress_over_young", [-0.25, -0.1, 0.2])
def test_a_block_on_a_table_shortens_as_its_energy_predicts(stress_over_young: float) -> None:
    """Use a material without lateral strain: s = 1 + stress / E, exactly."""
    material = Material(young_pa=50e3, poisson=0.0)
    size = (0.012, 0.012, 0.006)
    rest, tets = box(size, (3, 3, 2))
    tissue = overdamped(rest, tets, material, fixed=rest[:, 2] == 0)
    load = np.zeros_like(rest)
    load[:, 2] = stress_over_young * material.young_pa * face_share(rest, tets, 2, size[2])
    x = settle(tissue, load)
    expected = rest * [1.0, 1.0, 1.0 + stress_over_young]
    assert np.abs(x - expected).max() < 100 * (SETTLED_M + EPS * size[0])


@pytest.mark.parametrize("loaded", LOADINGS)
def test_a_refined_cantilever_converges_to_timoshenkos_beam(loaded: str) -> None:
    """Check that the deflection converges from below, with an error of second order."""
    beam = cantilever(loaded)
    # small enough for a linear theory
    assert timoshenko_m(np.array(LENGTH_M), loaded) < 0.05 * LENGTH_M
    assert np.all(np.diff(beam.tip_m) > 0)
    assert np.all((beam.excess > 0) & (beam.excess < beam.max_excess))
    assert np.all((beam.order > 1.5) & (beam.order < 2.0))
    assert beam.excess[-1] < 0.18


def test_a_blocks_volume_changes_as_its_bulk_modulus_predicts() -> None:
    block = volume([0.0, 0.3, 0.45, 0.49])
    assert block.strain.min() > 0.004  # it is deformed
    assert np.all(np.abs(block.change - block.expected) < block.tolerance)
    assert np.all(block.tolerance < 0.25 * block.expected)
    assert block.change[-1] < block.strain[-1] / 20


def test_no_element_is_inverted_by_a_squeeze() -> None:
    """Press a nearly incompressible block on a table by more than half its modulus."""
    material = Material(young_pa=50e3, poisson=0.45)
    size = (0.016, 0.016, 0.006)
    rest, tets = box(size, (4, 4, 3))
    tissue = overdamped(rest, tets, material, fixed=rest[:, 2] == 0)
    load = np.zeros_like(rest)
    load[:, 2] = -0.6 * material.young_pa * face_share(rest, tets, 2, size[2])
    x = settle(tissue, load)
    assert x[:, 2].max() < 0.8 * size[2]
    assert tissue.volumes().min() > 0


def test_a_block_between_springs_behaves_as_two_springs_in_series() -> None:
    block = squeezed_block([0.3, 3.0])
    np.testing.assert_allclose(block.height, block.expected, atol=1e-5)


def test_a_stretched_strip_gapes_by_its_stretch_when_cut_through() -> None:
    cut = whole_cut([0.05, 0.4])
    np.testing.assert_allclose(cut.gap_m, cut.stretched_m, atol=100 * SETTLED_M)


def test_a_refined_slit_converges_to_fracture_mechanics() -> None:
    """Check that it converges from below, and that half the cell size halves the error."""
    cut = slit([4, 8, 16])
    assert np.all((cut.shortfall > 0) & (cut.shortfall < cut.max_shortfall))
    assert abs(cut.order[-1] - 1) < 0.2


@pytest.mark.parametrize("friction", [0.1, 0.5])
def test_a_block_sticks_inside_the_friction_cone_and_slides_outside(friction: float) -> None:
    held = friction_cone(friction, [0.5, 0.9])
    assert np.all(np.abs(held.slid_m) < held.creep_m)
    np.testing.assert_allclose(held.ratio, held.slope, rtol=0.02)
    slides = friction_cone(friction, [1.2, 2.0])
    assert np.all((slides.slid_m > slides.min_m) & (slides.slid_m < slides.max_m))
    assert np.all(slides.ratio > friction)
    assert np.all(slides.ratio < friction * (1 + FRICTION_ERROR))
