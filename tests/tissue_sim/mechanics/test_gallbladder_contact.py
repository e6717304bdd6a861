"""Tests of tubes against the gallbladder: a tube stays outside, pushes are mutual, rest is rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.tissue_sim.bodies import forces
from tests.tissue_sim.verification.bodies import EPS, put, tissue_of
from tissue_sim.frames import Array, unit
from tissue_sim.mechanics.gallbladder_contact import RING_STIFFNESS
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.topology import distances_to_triangles, encloses
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.organ import TUBE_SECTORS, TUBES, Organ, build_organ
from tissue_sim.patient.sac import Sac
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.walls import n_patches

SEEDS = (10_003, 10_005, 10_007)


def height_m(tissue: Tissue, corners: Array) -> float:
    """Return how far the middle of a ring's corners is outside of the skin; below 0 inside."""
    x = tissue.positions().astype(float)
    skin = x[tissue.host("skin")[0, : tissue.host("n_skin")[0]]]
    middle = x[corners].mean(axis=0)
    side = -1.0 if encloses(skin, middle[None])[0] else 1.0
    return side * float(distances_to_triangles(skin, middle).min())


def least_height(seed: int, tube: str, load_n: float, *, contact: bool) -> float:
    """Press a tube's upper part against the gallbladder; return its least height in its radii."""
    organ = build_organ(textbook_from_seed(seed))
    of_sac = np.isin(np.arange(len(organ.vertices)), organ.sac_rings)
    organ = replace(organ, fixed=organ.fixed & ~of_sac)  # nobody holds the fundus: the sac yields
    tissue = Tissue([organ])
    tissue.host("link_stiffness")[:] = 0.0  # strands would keep it from the gallbladder
    if not contact:
        tissue.host("ring_beside_sac")[:] = 0
    last = organ.neck_ring[tube]
    rings = organ.rings[tube][last - 9 : last - 2]
    loaded, target = rings.ravel(), organ.sac_rings[6]
    least = np.inf
    for k in range(150):
        x = tissue.positions().astype(float)
        towards = unit(x[target].mean(axis=0) - x[loaded].mean(axis=0))
        tissue.host("load")[0][:] = 0.0
        tissue.host("load")[0][loaded] = load_n * min(k / 100, 1.0) * towards / len(loaded)
        tissue.step()
        if k > 50 and k % 5 == 0:
            least = min(least, *(height_m(tissue, r[-TUBE_SECTORS:]) for r in rings))
    return least / float(tissue.host("tube_radius")[0, TUBES.index(tube)])


@pytest.mark.parametrize("seed", SEEDS[:2])
@pytest.mark.parametrize(("tube", "load_n"), [("duct", 3.5), ("artery", 1.0)])
def test_a_tube_that_is_pulled_against_the_gallbladder_does_not_enter_it(
    seed: int, tube: str, load_n: float
) -> None:
    assert 0.6 < least_height(seed, tube, load_n, contact=True) < 1.05
    assert least_height(seed, tube, load_n, contact=False) < 0.0


def moved_into_sac(organ: Organ, ring: int, depth_m: float) -> tuple[Array, Array]:
    """Put one ring of the duct this deep into the nearest face of the skin.

    Returns:
        the vertices (n, 3), and the face's outward normal.
    """
    tissue = Tissue([organ])
    skin = organ.vertices[tissue.host("skin")[0, : tissue.host("n_skin")[0]]]
    x = organ.vertices.copy()
    centre = x[organ.rings["duct"][ring, 0]]
    face = skin[distances_to_triangles(skin, centre).argmin()]
    outward = unit(np.cross(face[1] - face[0], face[2] - face[0]))
    radius = float(tissue.host("tube_radius")[0, 0])
    x[organ.rings["duct"][ring]] += face.mean(axis=0) + (radius - depth_m) * outward - centre
    return x, outward


@pytest.mark.parametrize("depth_m", [3e-4, 2.5e-3], ids=["outside", "inside"])
def test_tube_and_gallbladder_push_each_other_with_opposite_forces(depth_m: float) -> None:
    organ = build_organ(textbook_from_seed(SEEDS[0]))
    tissue = tissue_of(organ, None)
    ring = organ.neck_ring["duct"] // 2
    moved, outward = moved_into_sac(organ, ring, depth_m)
    put(tissue, moved)
    f = forces(tissue, "tube contact")
    x = tissue.positions()
    on_ring = f[organ.rings["duct"][ring]].sum(axis=0) @ outward
    assert on_ring == pytest.approx(float(RING_STIFFNESS) * depth_m, rel=1e-3)
    rounding = 50 * EPS * np.abs(f).sum()
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=rounding)
    np.testing.assert_allclose(np.cross(x, f).sum(axis=0), 0.0, atol=10 * rounding)


def test_a_hole_in_the_wall_pushes_no_tube() -> None:
    """Open the whole wall; the flat lower side of the neck, which is filling, stays."""
    organ = build_organ(textbook_from_seed(SEEDS[0]))
    tissue = tissue_of(organ, None)
    outer = organ.sac_rings[1:, 11:].ravel()
    put(tissue, moved_into_sac(organ, organ.neck_ring["duct"] // 2, 2.5e-3)[0])
    assert np.abs(forces(tissue, "tube contact")[outer]).max() > 0.1
    Sac(tissue, organ).open(np.arange(n_patches(organ)))
    assert not forces(tissue, "tube contact")[outer].any()


@pytest.mark.parametrize("seed", SEEDS)
def test_at_rest_tubes_and_gallbladder_do_not_push_each_other(seed: int) -> None:
    """Check whole tubes of two kinds of patients: only where they join the sac are rings exempt."""
    for anatomy in (textbook_from_seed(seed), anatomy_from_seed(seed)):
        organ = build_organ(anatomy)
        tissue = Tissue([organ], stiffness_scale=[anatomy.stiffness_scale])
        for k, tube in enumerate(organ.tubes):
            beside = tissue.host("ring_beside_sac")[0, k, : organ.neck_ring[tube] + 1]
            assert not beside[-1]
            assert beside[:-3].all()
        for _ in range(45):
            tissue.step()
        assert not forces(tissue, "tube contact").any()
