"""Tests of abuses: what a careless hand does is an injury, and its careful counterpart is not.

Each abuse is done with bare hands, without a safety filter, on a patient at rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from controller.expert.targets import grasp_pose
from tests.tissue_sim.hands import before_sac, close, move, poke, put, wait
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.frames import AWAY, LEFT, RIGHT, Array, pose, unit
from tissue_sim.outcome.predicates import procedure_flags
from tissue_sim.patient.at_risk import AT_RISK, COMMON_DUCT, HEPATIC_ARTERY
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.surgery.abuses import WALL_M, WALL_PA, fold_pressure_pa
from tissue_sim.surgery.cut import BLADE_LENGTH_M
from tissue_sim.thresholds import CRUSH_MAX_N, CRUSHED_M2
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.world import World

SEED = 10_003
OPEN_RAD = 0.6
PRESSED_RAD = -0.3


@pytest.fixture(scope="module")
def at_rest(one_world: World) -> dict[str, Any]:
    one_world.reset(textbook_from_seed(SEED))
    return one_world.state()


@pytest.fixture
def world(one_world: World, at_rest: dict[str, Any]) -> World:
    one_world.restore(at_rest)
    return one_world


def across(world: World, tube: str, share: float = 0.4, beyond_m: float = 0.004) -> Array:
    """Return `T_world_tool` of jaws astride a tube at a share of its length."""
    return astride(world.tubes, tube, share * world.tubes.length_m[tube], beyond_m=beyond_m)


def at_risk(world: World, trunk: str, before_m: float) -> Array:
    """Return `T_world_tool` of jaws astride a trunk beside its branch, or this far before it."""
    T = across(world, trunk, 0.75, 0.5 * POLYMER.length_m)
    T[:3, 3] -= before_m * T[:3, 2]
    return T


def grip(world: World, tube: str, jaw_rad: float) -> None:
    """Take a structure at risk between the grasper's jaws."""
    put(world, LEFT_ARM, at_risk(world, tube, 0.0), 1.0)
    close(world, LEFT_ARM, jaw_rad, steps=15)
    wait(world, 5)


def beside_sac(world: World) -> Array:
    """Return `T_world_tool` of a tool that points at the bare liver, 20 mm in front of it."""
    bed = world.organ.bed
    place = bed.point_m + (bed.edge_m + 0.03) * bed.along + 0.035 * RIGHT - 0.02 * AWAY
    y = unit(np.cross(AWAY, RIGHT))
    return pose(np.stack([np.cross(y, AWAY), y, AWAY], axis=1), place)


def use(world: World, T_world_tool: Array, intended: str | None, tool: str) -> None:
    """Close a fresh clip, or the scissors, at a pose, and take the tool away."""
    world.equip(tool)
    put(world, RIGHT_ARM, T_world_tool, OPEN_RAD)
    close(world, RIGHT_ARM, PRESSED_RAD, steps=20, intended=intended)


def clip(world: World, tube: str, share: float) -> None:
    use(world, across(world, tube, share, POLYMER.length_m / 2), tube, "clip_applier")


def cut(world: World, tube: str, share: float, intended: str | None = None) -> None:
    use(world, across(world, tube, share, BLADE_LENGTH_M / 2), intended or tube, "scissors")


def grasp(world: World) -> None:
    put(world, LEFT_ARM, grasp_pose(world), 1.0)
    close(world, LEFT_ARM, 0.1, steps=25)


def drag(world: World, distance_m: float, speed_m_s: float, way: Array) -> None:
    """Grasp the gallbladder and draw it away."""
    grasp(world)
    move(world, LEFT_ARM, distance_m * way, speed_m_s=speed_m_s)
    wait(world, 3)


def drag_the_freed_sac(world: World) -> None:
    """Cut both tubes, which hold more than the liver bed, and draw the gallbladder off it."""
    for tube in TUBES:
        cut(world, tube, 0.5)
    drag(world, 0.060, 0.1, LEFT)


def squeeze(world: World, arm: int, tube: str, jaw_rad: float) -> None:
    """Take a tube between the jaws of the grasper or of the empty applier."""
    if arm == RIGHT_ARM:
        world.drop_clip()
    put(world, arm, across(world, tube), OPEN_RAD)
    close(world, arm, jaw_rad, steps=15)
    wait(world, 5)


def squeeze_neck(world: World, jaw_rad: float) -> None:
    """Take the gallbladder's neck between the jaws of the empty applier."""
    world.drop_clip()
    put(world, RIGHT_ARM, before_sac(world, 1, 0.006), OPEN_RAD)
    close(world, RIGHT_ARM, jaw_rad, steps=15)
    wait(world, 5)


def lose_clips(world: World, count: int) -> None:
    for _ in range(count):
        world.equip("clip_applier")
        world.drop_clip()
        wait(world, 5)


def clip_often(world: World, *shares: float) -> None:
    """Put clips on the duct at these shares of its length."""
    for share in shares:
        clip(world, "duct", share)


def sweep(world: World, distance_m: float, speed_m_s: float) -> None:
    """Draw the closed applier from outside across the duct and on to the artery."""
    inwards = RIGHT if world.anatomy.structure("left") == "duct" else LEFT
    T = across(world, "duct", 0.5, 0.010)
    T[:3, 3] -= 0.012 * inwards
    put(world, RIGHT_ARM, T, 0.0)
    move(world, RIGHT_ARM, distance_m * inwards, speed_m_s=speed_m_s)
    wait(world, 2)


def scratch_liver(world: World, distance_m: float) -> None:
    """Drive the closed scissors at the bare liver."""
    world.equip("scissors")
    put(world, RIGHT_ARM, beside_sac(world), 0.0)
    move(world, RIGHT_ARM, distance_m * AWAY, speed_m_s=0.05)


def ram_the_grasper(world: World, share: float) -> None:
    """Drive the applier a share of the way to the grasper."""
    left, right = world.arms.T_world_tool()[:, :3, 3]
    move(world, RIGHT_ARM, share * (left - right), speed_m_s=0.1)


def push_on_tube(world: World, tube: str, distance_m: float) -> None:
    """Push the closed applier straight at a tube."""
    T = across(world, tube, 0.5, -0.006)
    put(world, RIGHT_ARM, T, 0.0)
    move(world, RIGHT_ARM, (0.006 + distance_m) * T[:3, 2], speed_m_s=0.05)


def clip_both(world: World, gap_m: float) -> None:
    """Close a clip on the duct while the artery lies beside it, with this gap."""
    world.equip("clip_applier")
    T = across(world, "duct", 0.4, POLYMER.length_m - 0.002)
    put(world, RIGHT_ARM, T, OPEN_RAD)
    points = [world.tubes.point(t, 0.4 * world.tubes.length_m[t])[0] for t in ("duct", "artery")]
    radii_m = world.tubes.radius_m("duct") + world.tubes.radius_m("artery")
    world.tissue.host("tie_stiffness")[0, world.tubes.root_rows[HEPATIC_ARTERY]] = 0.0
    world.tissue.host("fixed")[0, world.tubes.below["artery"][0]] = 1  # its root is held there
    shift = points[0] + (gap_m + radii_m) * T[:3, 2] - points[1]
    world.tissue.positions()[world.tubes.below["artery"]] += shift.astype(np.float32)
    close(world, RIGHT_ARM, 0.0, steps=1, intended="duct")


@dataclass(frozen=True, kw_only=True)
class Abuse:
    """One way to hurt.

    Attributes:
        event: the injury that must follow.
        careless: what does it.
        careful: the same with care, which must not be an injury of any kind.
    """

    event: str
    careless: Callable[[World], None]
    careful: Callable[[World], None]


def cut_between_clips(world: World) -> None:
    clip_often(world, 0.2, 0.36, 0.75)
    cut(world, "duct", 0.55)
    wait(world, 10)


def cut_unclipped(world: World) -> None:
    cut(world, "duct", 0.55)
    wait(world, 10)


OFF_LIVER = unit(0.5 * LEFT - AWAY)

ABUSES = {
    "the grasper crushes the duct": Abuse(
        event="crush of duct",
        careless=lambda w: squeeze(w, LEFT_ARM, "duct", PRESSED_RAD),
        careful=lambda w: squeeze(w, LEFT_ARM, "duct", 0.1),
    ),
    "the empty applier crushes the duct": Abuse(
        event="crush of duct",
        careless=lambda w: squeeze(w, RIGHT_ARM, "duct", PRESSED_RAD),
        careful=lambda w: squeeze(w, RIGHT_ARM, "duct", 0.12),
    ),
    "the empty applier crushes the gallbladder": Abuse(
        event="crush of gallbladder",
        careless=lambda w: squeeze_neck(w, PRESSED_RAD),
        careful=lambda w: squeeze_neck(w, 0.12),
    ),
    "the gallbladder is dragged at 0.3 m/s": Abuse(
        event="stretch of artery",
        careless=lambda w: drag(w, 0.030, 0.3, LEFT),
        careful=lambda w: drag(w, 0.008, 0.02, LEFT),
    ),
    "the gallbladder is pulled off its bed": Abuse(
        event="detachment from liver bed",
        careless=drag_the_freed_sac,
        careful=lambda w: drag(w, 0.010, 0.02, OFF_LIVER),
    ),
    "the gallbladder is pressed on the liver": Abuse(
        event="liver force through gallbladder",
        careless=lambda w: drag(w, 0.020, 0.05, -w.organ.bed.normal),
        careful=lambda w: drag(w, 0.005, 0.02, -w.organ.bed.normal),
    ),
    "the gallbladder is pulled too hard": Abuse(
        event="traction",
        careless=lambda w: drag(w, 0.040, 0.05, -w.organ.bed.normal),
        careful=lambda w: drag(w, 0.010, 0.02, LEFT),
    ),
    "ten clips are lost": Abuse(
        event="clips left in the body",
        careless=lambda w: lose_clips(w, 10),
        careful=lambda w: lose_clips(w, 2),
    ),
    "clips at one station": Abuse(
        event="clip on clip",
        careless=lambda w: clip_often(w, 0.4, 0.4, 0.4, 0.4),
        careful=lambda w: clip_often(w, 0.2, 0.36, 0.53, 0.72),
    ),
    "scissors rammed into the neck of the gallbladder": Abuse(
        event="perforation of gallbladder",
        careless=lambda w: poke(w, "scissors", 4, 0.012),
        careful=lambda w: poke(w, "scissors", 4, 0.001),
    ),
    "scissors rammed into the body of the gallbladder": Abuse(
        event="perforation of gallbladder",
        careless=lambda w: poke(w, "scissors", 8, 0.012),
        careful=lambda w: poke(w, "scissors", 8, 0.001),
    ),
    "the applier rammed into the gallbladder": Abuse(
        event="perforation of gallbladder",
        careless=lambda w: poke(w, "clip_applier", 6, 0.012),
        careful=lambda w: poke(w, "clip_applier", 6, 0.001),
    ),
    "a sweep across both tubes": Abuse(
        event="blunt force",
        careless=lambda w: sweep(w, 0.040, 0.3),
        careful=lambda w: sweep(w, 0.010, 0.02),
    ),
    "the closed applier pushed at the artery": Abuse(
        event="stretch of artery",
        careless=lambda w: push_on_tube(w, "artery", 0.015),
        careful=lambda w: push_on_tube(w, "artery", 0.001),
    ),
    "scissors on the liver": Abuse(
        event="liver force",
        careless=lambda w: scratch_liver(w, 0.030),
        careful=lambda w: scratch_liver(w, 0.020),
    ),
    "instruments rammed together": Abuse(
        event="instrument contact",
        careless=lambda w: ram_the_grasper(w, 0.9),
        careful=lambda w: ram_the_grasper(w, 0.3),
    ),
    "a clip on the gallbladder": Abuse(
        event="clip on gallbladder",
        careless=lambda w: use(w, before_sac(w, 3, 0.005), "duct", "clip_applier"),
        careful=lambda w: clip(w, "duct", 0.4),
    ),
    "a cut on the gallbladder": Abuse(
        event="cut on gallbladder",
        careless=lambda w: use(w, before_sac(w, 5, 0.004), "duct", "scissors"),
        careful=lambda w: use(w, before_sac(w, 5, -0.004), "duct", "scissors"),
    ),
    "a clip across both tubes": Abuse(
        event="clip on artery",
        careless=lambda w: clip_both(w, 0.0),
        careful=lambda w: clip(w, "duct", 0.4),
    ),
    **{
        f"the {tool} closed on the {trunk}": Abuse(
            event=f"{deed} on {trunk}",
            careless=lambda w, trunk=trunk, tool=tool: use(w, at_risk(w, trunk, 0.0), "duct", tool),
            careful=lambda w, trunk=trunk, tool=tool: use(
                w, at_risk(w, trunk, 0.012), "duct", tool
            ),
        )
        for trunk in AT_RISK
        for tool, deed in (("scissors", "cut"), ("clip_applier", "clip"))
    },
    "a clip on the common bile duct that nobody meant": Abuse(
        event="clip on common bile duct",
        careless=lambda w: use(w, at_risk(w, COMMON_DUCT, 0.0), None, "clip_applier"),
        careful=lambda w: use(w, at_risk(w, COMMON_DUCT, 0.012), None, "clip_applier"),
    ),
    "the grasper crushes the common bile duct": Abuse(
        event="crush of common bile duct",
        careless=lambda w: grip(w, COMMON_DUCT, PRESSED_RAD),
        careful=lambda w: grip(w, COMMON_DUCT, 0.6),
    ),
    "a cut before the clips": Abuse(
        event="leak",
        careless=cut_unclipped,
        careful=cut_between_clips,
    ),
    "a cut on the wrong tube": Abuse(
        event="cut on artery",
        careless=lambda w: cut(w, "artery", 0.5, intended="duct"),
        careful=cut_between_clips,
    ),
}


def test_a_folds_pressure_grows_with_the_logarithm_of_its_squeeze() -> None:
    """Check the limit, too: 500 kPa are reached at a seventh of both walls' thickness."""
    assert fold_pressure_pa(2.0 * WALL_M) == 0.0
    assert fold_pressure_pa(4.0 * WALL_M) == 0.0
    halved = fold_pressure_pa(WALL_M)
    assert halved == pytest.approx(WALL_PA * np.log(2.0))
    assert fold_pressure_pa(0.5 * WALL_M) == pytest.approx(2.0 * halved)
    at_limit_m = 2.0 * WALL_M * np.exp(-CRUSH_MAX_N / CRUSHED_M2 / WALL_PA)
    assert at_limit_m == pytest.approx(2.0 * WALL_M / 7.0, rel=0.02)
    assert fold_pressure_pa(at_limit_m) * CRUSHED_M2 == pytest.approx(CRUSH_MAX_N)


@pytest.mark.parametrize("abuse", ABUSES.values(), ids=ABUSES)
def test_an_abuse_fails_the_episode_for_its_reason(world: World, abuse: Abuse) -> None:
    abuse.careless(world)
    hurt = [injury for injury in world.record.injuries if injury.event == abuse.event]
    assert hurt
    assert not procedure_flags(world)["no injury"]
    peaks = {peak.event: peak.value for peak in world.record.peaks}
    assert all(peaks[i.event] >= i.value > i.limit for i in hurt if i.limit > 0.0)


@pytest.mark.parametrize("abuse", ABUSES.values(), ids=ABUSES)
def test_the_same_with_care_is_no_injury(world: World, abuse: Abuse) -> None:
    abuse.careful(world)
    assert world.record.injuries == ()


def test_an_applier_that_closes_its_clip_does_not_crush_what_the_clip_holds(world: World) -> None:
    """Take a wide, stiff duct, which presses on the fingers until they let go of the clip."""
    world.reset(replace(textbook_from_seed(SEED), duct_diameter_m=0.0055, stiffness_scale=2.0))
    use(world, across(world, "duct", 0.5, POLYMER.length_m / 2), "duct", "clip_applier")
    assert world.record.clips[-1].on("duct")
    assert world.record.injuries == ()
