"""Tests of strands: instruments catch them, draw them taut, let them slide off or break them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.tissue_sim.bodies import dense_stiffness, forces
from tests.tissue_sim.mechanics.test_touch import place
from tests.tissue_sim.verification.bodies import EPS, tissue_of
from tissue_sim.frames import Array, pose, unit
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.material import REMNANT_STIFFNESS, REMNANT_STRENGTH
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.textbook import textbook_from_seed

SEED = next(s for s in range(100) if textbook_from_seed(s).remnants >= 4)
SHAFT, FINGER = 4, 6
RADIUS_M = 0.001
STRAND = 0


@pytest.fixture(scope="module")
def one_tissue() -> Tissue:
    tissue = tissue_of(build_organ(textbook_from_seed(SEED)), None)
    tissue.host("fixed")[:] = 1
    tissue.host("link_stiffness")[0, 1:] = 0.0
    return tissue


@pytest.fixture
def tissue(one_tissue: Tissue) -> Tissue:
    """Return a tissue that does not move, with one strand."""
    one_tissue.host("link_stiffness")[0, STRAND] = REMNANT_STIFFNESS
    one_tissue.host("link_strength")[0, STRAND] = REMNANT_STRENGTH
    one_tissue.host("strand_shape")[:] = -1
    place(one_tissue, {})
    one_tissue.step()
    return one_tissue


def frame(tissue: Tissue) -> tuple[Array, Array, Array, Array]:
    """Return the strand's middle, its direction, and two directions across it."""
    p, q = tissue.positions()[tissue.host("link")[0, STRAND]].astype(float)
    along = unit(q - p)
    aside = unit(np.cross(along, [0.3, 0.5, 0.8]))
    return 0.5 * (p + q), along, aside, np.cross(along, aside)


def put_tool(tissue: Tissue, offset_m: float, *, row: int = SHAFT, tip_m: float = 0.02,
             before_m: float | None = None, width: Array | None = None) -> None:  # fmt: skip
    """Put a rod or a finger across the strand, its axis this far aside of the middle."""
    middle, _, aside, axis = frame(tissue)

    def at(offset: float) -> Array:
        return pose(np.eye(3), middle + offset * aside)

    centre = middle + offset_m * aside
    before = offset_m if before_m is None else before_m
    tool = {"a": centre - 0.02 * axis, "b": centre + tip_m * axis, "radius": RADIUS_M,
            "half_width": np.zeros(3) if width is None else width, "friction": 0.0,
            "T_world_link": at(offset_m), "T_world_link_before": at(before)}  # fmt: skip
    place(tissue, {row: tool})


def draw(tissue: Tissue, start_m: float, end_m: float, steps: int, **how) -> None:
    """Move the tool aside in steps."""
    ways = np.linspace(start_m, end_m, steps + 1)
    for before, now in pairwise(ways):
        put_tool(tissue, float(now), before_m=float(before), **how)
        tissue.step()


def caught(tissue: Tissue) -> bool:
    return tissue.host("strand_shape")[0, STRAND] >= 0


def whole(tissue: Tissue) -> bool:
    return tissue.host("link_stiffness")[0, STRAND] > 0.0


def tension_n(tissue: Tissue, beyond_m: float) -> float:
    """Return the tension of a strand that a point this far aside of its middle draws taut."""
    p, q = tissue.positions()[tissue.host("link")[0, STRAND]].astype(float)
    half = 0.5 * np.linalg.norm(q - p)
    longer = 2.0 * np.hypot(half, beyond_m) - tissue.host("link_rest")[0, STRAND]
    return REMNANT_STIFFNESS * max(longer, 0.0)


@pytest.mark.parametrize("steps", [1, 20])
def test_a_tool_draws_a_strand_taut_by_the_lever_of_its_legs(tissue: Tissue, steps: int) -> None:
    """Check slow and fast tools: the strand lies on the side that the tool came to first."""
    draw(tissue, 0.003, -0.002, steps)
    assert caught(tissue)
    middle, along, aside, _ = frame(tissue)
    beyond = 0.002 + RADIUS_M
    T = tension_n(tissue, beyond)
    assert T > 0.01
    p, q = tissue.positions()[tissue.host("link")[0, STRAND]].astype(float)
    to_ends = unit(p - middle + beyond * aside) + unit(q - middle + beyond * aside)
    force = tissue.tool_wrenches()[0][SHAFT].astype(float)
    np.testing.assert_allclose(force, T * to_ends, atol=2e-3 * T)
    assert abs(force @ along) < 1e-3 * T


def test_a_tool_that_comes_back_lets_the_strand_go(tissue: Tissue) -> None:
    draw(tissue, 0.003, -0.002, 10)
    assert caught(tissue)
    draw(tissue, -0.002, 0.004, 12)
    assert not caught(tissue)
    assert whole(tissue)
    assert not tissue.tool_wrenches()[0].any()


def test_a_strand_breaks_at_its_strength(tissue: Tissue) -> None:
    steps = np.linspace(0.003, -0.012, 151)
    for before, now in pairwise(steps):
        put_tool(tissue, float(now), before_m=float(before))
        tissue.step()
        if not whole(tissue):
            break
    assert not whole(tissue)
    assert not caught(tissue)
    apart = abs(now - before)
    beyond = RADIUS_M - now
    assert tension_n(tissue, beyond - apart) <= REMNANT_STRENGTH * 1.01
    assert tension_n(tissue, beyond) >= REMNANT_STRENGTH * 0.99
    assert not tissue.tool_wrenches()[0].any()


def test_a_tool_that_passes_beyond_its_tip_catches_nothing(tissue: Tissue) -> None:
    draw(tissue, 0.003, -0.003, 12, tip_m=-2 * RADIUS_M)
    assert not caught(tissue)


def test_a_strand_slides_off_a_slippery_tip(tissue: Tissue) -> None:
    """Tilt the strand's pull towards the tip by moving its ends along the tool's axis."""
    _, _, _, axis = frame(tissue)
    draw(tissue, 0.003, -0.002, 10, tip_m=0.002)
    assert caught(tissue)
    ends = tissue.host("link")[0, STRAND]
    before = tissue.positions()[ends].copy()
    put_tool(tissue, -0.002, tip_m=0.002)
    tissue.positions()[ends] += (0.006 * axis).astype(np.float32)
    for _ in range(20):
        tissue.step()
    off = not caught(tissue)
    tissue.positions()[ends] = before
    assert off


def test_a_finger_catches_a_strand_too(tissue: Tissue) -> None:
    _, along, _, _ = frame(tissue)
    draw(tissue, 0.004, -0.002, 4, row=FINGER, width=0.0012 * along)
    assert tissue.host("strand_shape")[0, STRAND] == FINGER


def test_a_clips_spring_is_no_strand(tissue: Tissue) -> None:
    tissue.host("link_strength")[0, STRAND] = 1e9
    draw(tissue, 0.003, -0.002, 10)
    assert not caught(tissue)


def test_stiffness_is_the_slope_of_a_caught_strands_force(tissue: Tissue) -> None:
    draw(tissue, 0.003, -0.002, 10)
    ends = tissue.host("link")[0, STRAND]
    tissue.host("tie_stiffness")[:] = 0.0
    tissue.shapes.friction.numpy()[0, SHAFT] = 10.0  # the contact point stays
    f = forces(tissue, "springs")
    K = dense_stiffness(tissue).reshape(tissue.n_vertex(), 3, tissue.n_vertex(), 3)
    K = K[ends][:, :, ends].reshape(6, 6)
    assert np.abs(K - K.T).max() <= 4 * EPS * np.abs(K).max()
    x = tissue.positions()[ends].copy()
    step = 2e-5
    for k in range(6):
        d = np.zeros(6, np.float32)
        d[k] = step
        tissue.positions()[ends] = x + d.reshape(2, 3)
        ahead = forces(tissue, "springs")[ends].ravel()
        tissue.positions()[ends] = x - d.reshape(2, 3)
        behind = forces(tissue, "springs")[ends].ravel()
        tissue.positions()[ends] = x
        slope = (ahead - behind) / (2.0 * step)
        np.testing.assert_allclose(slope, -K[:, k], atol=2e-3 * np.abs(K).max())
    assert np.abs(f[ends]).max() > 0.01
