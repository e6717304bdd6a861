"""Static bodies against closed forms: a stretched bar, a bent beam, a squeezed block."""

import numpy as np
import pytest

from tests.tissue_sim.bodies import EPS, box, organ_of, stretches_under, tissue_of
from tissue_sim.frames import Array
from tissue_sim.material import DENSITY_KG_M3, Material
from tissue_sim.sweep import Indices
from tissue_sim.tissue import Tissue
from tissue_sim.topology import boundary_faces

GRAVITY = 9.81
SETTLED_M = 1e-8


def face_share(vertices: Array, tets: Indices, axis: int, at: float) -> Array:
    """(n_vertex,) area of a plane side of the body that each vertex carries, m^2."""
    faces, _ = boundary_faces(tets)
    corners = vertices[faces]
    side = np.isclose(corners[:, :, axis], at).all(axis=1)
    edges = corners[side, 1:] - corners[side, :1]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return np.bincount(faces[side].ravel(), weights=np.repeat(area / 3, 3), minlength=len(vertices))


def settle(tissue: Tissue, load: Array | None = None, most: int = 400) -> Array:
    """Step under a load (n, 3) N until nothing moves; the positions."""
    if load is not None:
        tissue.host("load")[0, : tissue.n_vertex()] = load
    for _ in range(most):
        before = tissue.positions().astype(float)
        tissue.step()
        if np.abs(tissue.positions() - before).max() < SETTLED_M:
            return tissue.positions().astype(float)
    raise AssertionError("the body does not come to rest")


def creeping(vertices: Array, tets: Indices, material: Material, **organ: Array) -> Tissue:
    """A body so damped that it does not overshoot."""
    return tissue_of(
        organ_of(vertices, tets, **organ), material, step_s=0.002, damping_per_s=2000.0
    )


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45])
@pytest.mark.parametrize("stress_over_young", [0.02, 0.3])
def test_a_pulled_bar_stretches_as_its_energy_says(
    poisson: float, stress_over_young: float
) -> None:
    """A uniform traction on both ends makes F uniform, which linear elements hold exactly.

    Only pulled: a free body that is pressed turns over.
    """
    material = Material(young_pa=50e3, poisson=poisson)
    stress = stress_over_young * material.young_pa
    size = (0.02, 0.008, 0.008)
    rest, tets = box(size, (5, 2, 2))
    tissue = creeping(rest, tets, material)
    load = np.zeros_like(rest)
    load[:, 0] = stress * (face_share(rest, tets, 0, size[0]) - face_share(rest, tets, 0, 0.0))
    x = settle(tissue, load)
    F = np.linalg.lstsq(rest - rest.mean(axis=0), x - x.mean(axis=0), rcond=None)[0].T
    measured = np.linalg.svd(F)[1]
    along, across = stretches_under(stress, material)
    # what is left to settle, and the noise of a force (eps of the largest stress) in a strain
    tolerance = 100 * SETTLED_M / size[0] + 100 * EPS / (1 - 2 * poisson)
    assert measured[0] == pytest.approx(along, abs=tolerance)
    assert measured[1:] == pytest.approx([across, across], abs=tolerance)
    assert np.abs(x - x.mean(axis=0) - (rest - rest.mean(axis=0)) @ F.T).max() < tolerance * size[0]


@pytest.mark.parametrize("stress_over_young", [-0.25, -0.1, 0.2])
def test_a_block_on_a_table_shortens_as_its_energy_says(stress_over_young: float) -> None:
    """Without lateral strain: s = 1 + stress / E, exactly."""
    material = Material(young_pa=50e3, poisson=0.0)
    size = (0.012, 0.012, 0.006)
    rest, tets = box(size, (3, 3, 2))
    tissue = creeping(rest, tets, material, fixed=rest[:, 2] == 0)
    load = np.zeros_like(rest)
    load[:, 2] = stress_over_young * material.young_pa * face_share(rest, tets, 2, size[2])
    x = settle(tissue, load)
    expected = rest * [1.0, 1.0, 1.0 + stress_over_young]
    assert np.abs(x - expected).max() < 100 * (SETTLED_M + EPS * size[0])


BEAM = Material(young_pa=300e3, poisson=0.3)
LENGTH_M, WIDTH_M = 0.02, 0.004
SHEAR_MODULUS = BEAM.lame[0]
AREA, INERTIA = WIDTH_M**2, WIDTH_M**4 / 12
SHEAR_FACTOR = 10 * (1 + BEAM.poisson) / (12 + 11 * BEAM.poisson)  # Cowper, 1966
END_LOAD_N = 0.5 * DENSITY_KG_M3 * AREA * LENGTH_M * GRAVITY


def timoshenko_m(loaded: str) -> float:
    bending, shear = BEAM.young_pa * INERTIA, SHEAR_FACTOR * SHEAR_MODULUS * AREA
    if loaded == "at its end":
        return END_LOAD_N * (LENGTH_M**3 / (3 * bending) + LENGTH_M / shear)
    q = DENSITY_KG_M3 * AREA * GRAVITY
    return q * (LENGTH_M**4 / (8 * bending) + LENGTH_M**2 / (2 * shear))


def tip_m(n: int, loaded: str) -> float:
    """How far the tip of a cantilever with n cells across sinks."""
    rest, tets = box((LENGTH_M, WIDTH_M, WIDTH_M), (5 * n, n, n))
    weight = GRAVITY if loaded == "by its weight" else 0.0
    tissue = tissue_of(
        organ_of(rest, tets, fixed=rest[:, 0] == 0), BEAM,
        step_s=0.02, damping_per_s=5.0, gravity_m_s2=(0.0, 0.0, -weight), tolerance=1e-4,
    )  # fmt: skip
    end = face_share(rest, tets, 0, LENGTH_M)
    load = np.zeros_like(rest)
    if loaded == "at its end":
        load[:, 2] = -END_LOAD_N * end / end.sum()
    sunk = rest[:, 2] - settle(tissue, load)[:, 2]
    return float((sunk * end).sum() / end.sum())


@pytest.mark.parametrize("loaded", ["by its weight", "at its end"])
def test_a_cantilever_sinks_as_timoshenkos_beam_when_refined(loaded: str) -> None:
    """From below, and with an error of second order in the cells.

    A linear tetrahedron cannot bend: under a curvature k its strain misses k h / sqrt(6) (mean
    square) along the beam and k h / 2 in shear. Against the beam's energy E k^2 W^2 / 24 the mesh
    is too stiff by c (h / W)^2, c = 2 + 3 G / E, at most doubled by the coupling of the lateral
    strains.
    """
    beam, cells = timoshenko_m(loaded), np.array([1, 2, 4, 6])
    assert beam < 0.05 * LENGTH_M  # small enough for a linear theory
    tips = np.array([tip_m(n, loaded) for n in cells])
    excess = beam / tips - 1
    c = 2 + 3 * SHEAR_MODULUS / BEAM.young_pa
    assert np.all(np.diff(tips) > 0)
    assert np.all((excess > 0) & (excess < 2 * c / cells**2))
    assert excess[-1] < 0.18


def test_a_block_keeps_its_volume_as_its_bulk_modulus_says() -> None:
    """dV = sum f . x / (3 K) for any load, in any mesh that can stretch evenly (virtual work)."""
    material = Material(young_pa=50e3, poisson=0.45)
    bulk = material.young_pa / (3 * (1 - 2 * material.poisson))
    side = 0.01
    rest, tets = box((side,) * 3, (4, 4, 4))
    tissue = creeping(rest, tets, material)
    top, bottom = (face_share(rest, tets, 2, z) for z in (side, 0.0))
    middle = np.exp(-((rest[:, :2] - side / 2) ** 2).sum(axis=1) / (0.3 * side) ** 2)
    load = np.zeros_like(rest)
    load[:, 2] = 5e3 * middle * top
    load[:, 2] -= 5e3 * middle * bottom * (middle @ top) / (middle @ bottom)
    x = settle(tissue, load)
    strain = np.abs(x - x.mean(0) - rest + rest.mean(0)).max() / side
    change = tissue.volumes().sum() - side**3
    expected = (load * rest).sum() / (3 * bulk)
    assert strain > 0.005  # it is deformed
    # quadratic terms that the linear law leaves out, strain for strain
    pressed = material.young_pa * strain / bulk * side**3
    assert change == pytest.approx(expected, abs=10 * strain * pressed)
    assert abs(change) / side**3 < strain / 5


def test_every_element_keeps_its_side_up_when_squeezed() -> None:
    """A nearly incompressible block pressed on a table by more than half its modulus."""
    material = Material(young_pa=50e3, poisson=0.45)
    size = (0.016, 0.016, 0.006)
    rest, tets = box(size, (4, 4, 3))
    tissue = creeping(rest, tets, material, fixed=rest[:, 2] == 0)
    load = np.zeros_like(rest)
    load[:, 2] = -0.6 * material.young_pa * face_share(rest, tets, 2, size[2])
    x = settle(tissue, load)
    assert x[:, 2].max() < 0.8 * size[2]
    assert tissue.volumes().min() > 0
