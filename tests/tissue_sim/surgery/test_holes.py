"""Tests of holes: a branch torn off its trunk and a stabbed gallbladder leak."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tissue_sim.hands import poke
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.frames import Array, unit
from tissue_sim.patient.at_risk import BRANCHES, COMMON_DUCT
from tissue_sim.patient.material import WALL_THICKNESS_M
from tissue_sim.patient.walls import n_sectors, patch_corners
from tissue_sim.surgery.clip import latch
from tissue_sim.surgery.flow import FlowSegment, outflow_m3_s
from tissue_sim.surgery.leak import FLUIDS, PRESSURE_PA, Leak, root_leaks
from tissue_sim.thresholds import PIERCED_M
from tissue_sim.tools.arms import HOME_JOINTS, JointCommand
from tissue_sim.world import World

SEED = 10_003
HOLD = JointCommand(joints=np.tile(HOME_JOINTS, (2, 1)))


def tear_off(world: World, trunk: str, share: float = 1.0) -> None:
    """Break this share of the springs that hold a branch in its trunk."""
    rows = world.tubes.root_rows[trunk]
    world.tissue.host("tie_stiffness")[0, rows[: round(share * len(rows))]] = 0.0


def of(leaks: tuple[Leak, ...], structure: str) -> Leak:
    (leak,) = (leak for leak in leaks if leak.structure == structure)
    return leak


def test_a_whole_root_does_not_leak(world: World) -> None:
    world.step(HOLD)
    assert world.record.leaks == ()


@pytest.mark.parametrize("trunk", BRANCHES)
def test_a_branch_that_is_torn_off_leaks_from_the_trunk_and_from_itself(
    world: World, trunk: str
) -> None:
    branch = BRANCHES[trunk]
    tear_off(world, trunk)
    for _ in range(3):
        world.step(HOLD)
    found = world.record.leaks
    assert {(leak.structure, leak.side) for leak in found} == {
        (trunk, "hole"),
        (branch, "gallbladder"),
    }
    way = [
        FlowSegment(
            length_m=WALL_THICKNESS_M[trunk], area_m2=float(world.tubes.rest_lumen_m2(branch)[0])
        )
    ]
    rate = outflow_m3_s(FLUIDS[trunk], PRESSURE_PA[trunk, "body"], way)
    assert of(found, trunk).rate_m3_s == pytest.approx(rate)
    assert world.record.leaked_m3 > 0.0
    assert {i.event for i in world.record.injuries} >= {"leak", f"tear of {branch} from {trunk}"}
    root = world.tissue.positions()[world.organ.rings[branch][0, 0]]
    assert np.linalg.norm(world.tubes.root_m(trunk) - root) < 0.01


def test_a_root_that_is_half_torn_leaks_less(world: World) -> None:
    rates = []
    for share in (0.5, 1.0):
        tear_off(world, COMMON_DUCT, share)
        rates.append(of(root_leaks(world.tubes, ()), COMMON_DUCT).rate_m3_s)
    assert 0.3 * rates[1] < rates[0] < 0.7 * rates[1]


def test_a_clip_on_a_torn_branch_closes_the_branch_and_not_the_hole(world: World) -> None:
    T = astride(
        world.tubes, "duct", 0.5 * world.tubes.length_m["duct"], beyond_m=0.5 * POLYMER.length_m
    )
    clip = latch(world.tubes, T, POLYMER, number=1, time_s=0.0)
    for _ in range(30):
        world.tissue.step()
    tear_off(world, COMMON_DUCT)
    assert [leak.structure for leak in root_leaks(world.tubes, (clip,))] == [COMMON_DUCT]
    assert len(root_leaks(world.tubes, ())) == 2


@pytest.mark.parametrize("tool", ["scissors", "clip_applier"])
def test_a_stabbed_gallbladder_has_one_hole_where_the_tool_went_in_and_leaks(
    world: World, tool: str
) -> None:
    poke(world, tool, 6, 0.012)
    assert any(i.event == "perforation of gallbladder" for i in world.record.injuries)
    assert any(i.event == "leak" for i in world.record.injuries)
    holes = world.sac.open_patches()
    assert 1 <= len(holes) <= 3  # two fingers, and the wall moves along the tool
    near, far = (ends[6].astype(float) for ends in world.tissue.tool_axes())
    along = (far - near) / np.linalg.norm(far - near)
    off = world.sac.hole_centre() - near
    assert np.linalg.norm(off - (off @ along) * along) < 0.008
    assert of(world.record.leaks, "gallbladder").side == "hole"
    for _ in range(5):
        world.step(JointCommand(joints=world.target))
    assert len(world.sac.open_patches()) <= len(holes) + 1


def test_a_shallow_stab_makes_no_hole(world: World) -> None:
    poke(world, "scissors", 6, 0.5 * PIERCED_M)
    assert not world.sac.open_patches().size
    assert world.record.injuries == ()


@pytest.mark.parametrize("patch", [43, 46, 63])
@pytest.mark.parametrize("slant", [-1.0, 0.0, 1.0])
def test_the_pierced_patch_is_where_a_slanting_tool_enters(
    world: World, patch: int, slant: float
) -> None:
    corners = world.organ.vertices[patch_corners(world.organ)[patch, 1]]
    world.tissue.positions()[:] = world.organ.vertices
    middle, along = corners.mean(axis=0), unit(corners[2] - corners[0])
    inwards = unit(_centre(world, patch) - middle)
    way = unit(inwards + slant * along)
    tip, hilt = middle + 0.005 * way, middle - 0.04 * way
    assert world.sac.pierced(tip[None], hilt[None]).tolist() == [patch]
    world.sac.open(np.array([patch]))
    assert not world.sac.pierced(tip[None], hilt[None]).size


def _centre(world: World, patch: int) -> Array:
    ring = patch // n_sectors(world.organ)
    return world.organ.vertices[world.organ.sac_rings[ring : ring + 2, 0]].mean(axis=0)
