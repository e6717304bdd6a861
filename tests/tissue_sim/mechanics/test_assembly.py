"""Tests of the kept stiffness: it replaces the true one only while both are nearly the same."""

import numpy as np
import pytest

from tests.tissue_sim.bodies import dense_stiffness, forces
from tests.tissue_sim.verification.bodies import RUBBER, box, organ_of, put, tissue_of
from tissue_sim.frames import Array
from tissue_sim.mechanics.assembly import MAX_DRIFT
from tissue_sim.mechanics.tissue import Tissue

REST, TETS = box((0.02, 0.01, 0.01), (4, 2, 2))


def stretched(share: float) -> Array:
    return REST * (1.0 + share, 1.0, 1.0)


def body(x: Array) -> Tissue:
    """Return a block in shape x, before any stiffness was computed."""
    tissue = tissue_of(organ_of(REST, TETS), RUBBER)
    put(tissue, x)
    return tissue


def elements(tissue: Tissue) -> tuple[Array, Array]:
    """Return the forces and stiffness that the elements add at the current positions."""
    return forces(tissue, "elements"), dense_stiffness(tissue)


def test_after_a_small_motion_the_stiffness_is_kept_and_the_forces_are_current() -> None:
    near = 0.9 * float(MAX_DRIFT) / REST.max()
    tissue = body(stretched(0.2))
    _, before = elements(tissue)
    put(tissue, stretched(0.2 + near))
    force, kept = elements(tissue)
    force_here, stiffness_here = elements(body(stretched(0.2 + near)))
    np.testing.assert_array_equal(kept, before)
    np.testing.assert_array_equal(force, force_here)
    assert not np.array_equal(stiffness_here, before)
    assert np.abs(stiffness_here - kept).max() < 0.01 * np.abs(kept).max()


def test_after_a_large_motion_the_stiffness_is_computed_again() -> None:
    far = 1.1 * float(MAX_DRIFT) / REST.max()
    tissue = body(stretched(0.2))
    elements(tissue)
    put(tissue, stretched(0.2 + far))
    for here, fresh in zip(elements(tissue), elements(body(stretched(0.2 + far))), strict=True):
        np.testing.assert_array_equal(here, fresh)


def test_a_change_of_moduli_or_topology_invalidates_the_stiffness() -> None:
    tissue = body(stretched(0.2))
    _, before = elements(tissue)
    tissue.host("folded")[0, 0] = 1  # it stays folded while it has less than half its volume
    tissue.host("volume")[0, 0] *= 10.0
    tissue.stages["untangle"].launch()
    _, eased = elements(tissue)
    assert np.abs(eased - before).max() > 0.01 * np.abs(before).max()
    tissue = body(stretched(0.2))
    elements(tissue)
    tissue.host("tet_alive")[0, 0] = 0
    tissue.rewire(0)
    _, without = elements(tissue)
    assert np.trace(without) < np.trace(before)


@pytest.mark.parametrize("computed", [False, True])
def test_restoring_recovers_the_kept_stiffness(computed: bool) -> None:
    tissue = body(stretched(0.2))
    if computed:
        elements(tissue)
    put(tissue, stretched(0.2 + 0.9 * float(MAX_DRIFT) / REST.max()))
    state = tissue.state()
    expected = elements(tissue)
    put(tissue, stretched(0.3))
    elements(tissue)
    tissue.restore(state)
    for here, before in zip(elements(tissue), expected, strict=True):
        np.testing.assert_array_equal(here, before)
