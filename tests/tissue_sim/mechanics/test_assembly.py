"""Laws of the kept stiffness: it stands in for the true one only while that is nearly the same."""

import numpy as np
import pytest

from tests.tissue_sim.bodies import dense_stiffness, forces
from tissue_sim.frames import Array
from tissue_sim.mechanics.assembly import MAX_DRIFT
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.verification.bodies import RUBBER, box, organ_of, put, tissue_of

REST, TETS = box((0.02, 0.01, 0.01), (4, 2, 2))


def stretched(share: float) -> Array:
    return REST * (1.0 + share, 1.0, 1.0)


def body(x: Array) -> Tissue:
    """A block in shape x, with nothing worked out yet."""
    tissue = tissue_of(organ_of(REST, TETS), RUBBER)
    put(tissue, x)
    return tissue


def elements(tissue: Tissue) -> tuple[Array, Array]:
    """Forces and stiffness that the elements add where the vertices are now."""
    return forces(tissue, "elements"), dense_stiffness(tissue)


def test_near_by_the_stiffness_is_kept_and_the_forces_are_those_of_here() -> None:
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


def test_far_off_the_stiffness_is_worked_out_anew() -> None:
    far = 1.1 * float(MAX_DRIFT) / REST.max()
    tissue = body(stretched(0.2))
    elements(tissue)
    put(tissue, stretched(0.2 + far))
    for here, fresh in zip(elements(tissue), elements(body(stretched(0.2 + far))), strict=True):
        np.testing.assert_array_equal(here, fresh)


def test_a_change_of_bulk_or_topology_ends_its_time() -> None:
    tissue = body(stretched(0.2))
    _, before = elements(tissue)
    tissue.host("folded")[0, 0] = 1  # and not half its volume: it stays so
    tissue.host("volume")[0, 0] *= 10.0
    tissue.stages["untangle"].launch()
    _, eased = elements(tissue)
    assert np.abs(np.linalg.eigvalsh(eased)).max() < np.abs(np.linalg.eigvalsh(before)).max()
    tissue = body(stretched(0.2))
    elements(tissue)
    tissue.host("tet_alive")[0, 0] = 0
    tissue.rewire(0)
    _, without = elements(tissue)
    assert np.trace(without) < np.trace(before)


@pytest.mark.parametrize("worked_out", [False, True])
def test_restoring_brings_the_kept_stiffness_back(worked_out: bool) -> None:
    tissue = body(stretched(0.2))
    if worked_out:
        elements(tissue)
    put(tissue, stretched(0.2 + 0.9 * float(MAX_DRIFT) / REST.max()))
    state = tissue.state()
    expected = elements(tissue)
    put(tissue, stretched(0.3))
    elements(tissue)
    tissue.restore(state)
    for here, before in zip(elements(tissue), expected, strict=True):
        np.testing.assert_array_equal(here, before)
