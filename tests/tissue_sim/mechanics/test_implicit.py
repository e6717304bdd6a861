"""Tests of the step: free fall, drag, momentum, energy, and its order in the step's length."""

import numpy as np
import pytest

from tests.tissue_sim.bodies import forces
from tests.tissue_sim.verification.bodies import EPS, RUBBER, box, organ_of, put, tissue_of
from tests.tissue_sim.verification.time_step import ORDER_TOLERANCE, time_step
from tests.tissue_sim.verification.vibration import TOLERANCE as ENERGY_TOLERANCE
from tests.tissue_sim.verification.vibration import vibration
from tissue_sim.frames import Array
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.material import DENSITY_KG_M3, Material

SIZE_M = (0.02, 0.01, 0.01)
REST, TETS = box(SIZE_M, (4, 2, 2))
REST = REST - REST.mean(axis=0)
G = np.array([0.5, 1.0, -9.81])  # askew, so that no axis is special
H_S = 1.0 / 60.0
CG_TOLERANCE = 1e-6


def body(material: Material = RUBBER, **config) -> Tissue:
    return tissue_of(organ_of(REST, TETS), material, tolerance=CG_TOLERANCE, **config)


def mass(tissue: Tissue) -> Array:
    return tissue.host("mass")[0, : len(REST), None].astype(float)


def velocity(tissue: Tissue) -> Array:
    return tissue.host("velocity")[0, : len(REST)].astype(float)


def momentum(tissue: Tissue) -> Array:
    return (mass(tissue) * velocity(tissue)).sum(axis=0)


def spin(tissue: Tissue) -> Array:
    return np.cross(tissue.positions().astype(float), mass(tissue) * velocity(tissue)).sum(axis=0)


def total_energy(tissue: Tissue) -> float:
    kinetic = 0.5 * (mass(tissue) * velocity(tissue) ** 2).sum()
    return float(kinetic + tissue.elastic_energy_j()[0])


def shaken(seed: int, *, size: float, **config) -> Tissue:
    """Return a body that is deformed by a share of its size and has random velocities."""
    rng = np.random.default_rng(seed)
    tissue = body(**config)
    put(tissue, REST @ (np.eye(3) + rng.normal(0, size, (3, 3))).T)
    thrown = rng.normal(0, size, REST.shape) + rng.normal(0, 3 * size, 3)
    tissue.host("velocity")[0, : len(REST)] = thrown
    return tissue


def test_mass_is_density_times_volume() -> None:
    assert mass(body()).sum() == pytest.approx(DENSITY_KG_M3 * np.prod(SIZE_M), rel=100 * EPS)


def rounding_n(tissue: Tissue) -> float:
    """Return the sum of the forces that come from rounding alone, N.

    A row of the stiffness matrix sums to its rounding errors instead of zero, which resist the
    motion of a step; elastic forces cancel to their rounding errors.
    """
    moved = np.abs(velocity(tissue)).max() * tissue.config.step_s
    stiffest = np.abs(tissue.host("block")[0]).max()
    elastic = np.abs(forces(tissue, "elements")).sum()
    return EPS * (len(REST) * stiffest * moved + elastic)


@pytest.mark.parametrize("damping_per_s", [0.0, 20.0])
def test_free_fall_is_that_of_implicit_euler(damping_per_s: float) -> None:
    """Compare with v' = (v + h g) / (1 + c h), x' = x + h v'.

    Without drag, v = g t and x = g h^2 n (n + 1) / 2.
    """
    n, h = 60, 1 / 600
    tissue = body(gravity_m_s2=tuple(G), damping_per_s=damping_per_s, step_s=h)
    v, x = np.zeros(3), np.zeros(3)
    for _ in range(n):
        tissue.step()
        v = (v + h * G) / (1 + damping_per_s * h)
        x = x + h * v
    if damping_per_s == 0:
        np.testing.assert_allclose(v, G * n * h)
        np.testing.assert_allclose(x, G * h**2 * n * (n + 1) / 2)
    # a velocity is a difference of rounded positions over h
    rounded = EPS * np.abs(tissue.positions()).max()
    off = velocity(tissue) - v
    assert np.abs(off.mean(axis=0)).max() < n * CG_TOLERANCE * np.abs(G).max() * h + rounded / h
    assert np.abs(off).max() < 10 * rounded / h
    assert np.abs(tissue.positions() - REST - x).max() < n * rounded


@pytest.mark.parametrize("seed", range(3))
def test_a_free_body_keeps_its_momentum(seed: int) -> None:
    """Check the momentum: elastic forces sum to 0, and each step is solved to `CG_TOLERANCE`."""
    tissue = shaken(seed, size=0.03, step_s=H_S)
    before, bound = momentum(tissue), 0.0
    for _ in range(60):
        tissue.step()
        size = (mass(tissue) * np.abs(velocity(tissue))).sum()
        bound += CG_TOLERANCE * size + H_S * rounding_n(tissue)
    assert bound < 0.1 * np.abs(before).max()
    assert np.abs(momentum(tissue) - before).max() < bound


def test_a_spinning_body_loses_spin_at_the_rate_of_implicit_euler() -> None:
    """Check the loss of spin, which is of first order in h.

    In a step, dL = -h^2 sum v x f. For a body that turns at w under its own pull -m w^2 r, this is
    -(w h)^2 L. Over a time T the loss is w^2 h T. The linearisation adds a term of the next order.
    """
    w, T = 5.0, 0.05
    errors = []
    for h in (1 / 480, 1 / 960, 1 / 1920):
        tissue = body(step_s=h)
        put(tissue, REST)
        tissue.host("velocity")[0, : len(REST)] = np.cross([0, 0, w], REST)
        before = spin(tissue)
        for _ in range(round(T / h)):
            tissue.step()
        change = spin(tissue) - before
        errors.append(-change[2] / before[2] / (w**2 * h * T) - 1)
        assert np.abs(change[:2]).max() < 0.1 * abs(change[2])
    assert abs(errors[2]) < 0.15
    assert abs(errors[2]) < 0.5 * abs(errors[1]) < 0.5**2 * abs(errors[0])


@pytest.mark.parametrize(("h", "size"), [(1 / 60, 0.005), (1 / 240, 0.02), (1 / 960, 0.1)])
@pytest.mark.parametrize("seed", range(2))
def test_energy_of_a_vibration_never_grows(h: float, size: float, seed: int) -> None:
    """Use motions that strain no element by more than a few percent in a step."""
    tissue = shaken(seed, size=size, step_s=h)
    energies = [total_energy(tissue)]
    noise = 0.0
    for _ in range(40):
        tissue.step()
        energies.append(total_energy(tissue))
        speed = np.abs(velocity(tissue)).max()
        rounded = EPS * np.abs(tissue.positions()).max() / h
        noise = max(noise, rounding_n(tissue) * speed * h + mass(tissue).sum() * speed * rounded)
    assert noise < 1e-3 * energies[0]
    assert np.diff(energies).max() < 4 * noise
    assert energies[-1] < energies[0]


def test_a_violent_shake_dies_out_at_the_worlds_step() -> None:
    """Move elements by a third of their size per step: the energy may overshoot, but not grow."""
    tissue = shaken(0, size=0.1, step_s=H_S)
    tissue.host("velocity")[0, : len(REST)] -= momentum(tissue) / mass(tissue).sum()
    before = total_energy(tissue)
    for _ in range(40):
        tissue.step()
    assert total_energy(tissue) < 0.2 * before
    assert tissue.volumes().min() > 0


def test_halving_the_step_halves_the_error() -> None:
    """Let a soft cantilever go under gravity, and follow it for half a swing."""
    swing = time_step()
    assert swing.change_m[0] > 1e-4  # the motion is not trivial
    assert np.all(np.abs(swing.order - 1) < ORDER_TOLERANCE)


@pytest.mark.parametrize(("h", "damping_per_s"), [(1 / 60, 5.0), (1 / 600, 0.0), (1 / 2400, 20.0)])
def test_a_swing_decays_as_implicit_eulers_closed_form(h: float, damping_per_s: float) -> None:
    swing = vibration(h, damping_per_s)
    assert len(swing.energy) > 5
    np.testing.assert_allclose(swing.energy, swing.expected, atol=ENERGY_TOLERANCE)
    assert np.diff(swing.energy).max() < 0
    assert swing.energy[-1] == pytest.approx(swing.envelope[-1], rel=0.25, abs=1e-5)
