"""Tests of damage: walls tear at their ultimate strength, and not below it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.tissue_sim.bodies import rod
from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.patients import lumen_shares
from tests.tissue_sim.verification.bodies import astride, organ_of, put, tissue_of
from tests.tissue_sim.verification.stretch import stretches
from tissue_sim.frames import AWAY, Array, axis_angle, pose, unit
from tissue_sim.mechanics.topology import surface_faces
from tissue_sim.outcome.predicates import tube_cut
from tissue_sim.patient.material import DENSITY_KG_M3, MATERIALS, WALL_THICKNESS_M
from tissue_sim.patient.organ import REGIONS, TUBES
from tissue_sim.patient.tubes import Tubes
from tissue_sim.patient.walls import (
    FAILURE_STRETCH,
    SAC,
    n_patches,
    patch_stiffness,
    stiffness_pa,
    wall_pieces,
)
from tissue_sim.rendering.skin import CUT_LUMEN, build_skin
from tissue_sim.surgery.clip import latch
from tissue_sim.surgery.cut import BLADE_LENGTH_M, sever
from tissue_sim.surgery.flow import BILE, FlowSegment, outflow_m3_s
from tissue_sim.surgery.grasp import Grasp
from tissue_sim.surgery.injuries import other_readings, wall_loads
from tissue_sim.surgery.leak import BILE_PRESSURE_PA, hole_leak, leaks
from tissue_sim.surgery.tear import Tear, tear, worst_load
from tissue_sim.thresholds import (
    JOINT_MARGIN_RAD,
    PINCH_MAX_N,
    SAC_MAX_STRETCH,
    STRENGTH_PA,
)
from tissue_sim.tools.arms import HOME_JOINTS, RIGHT_ARM, JointCommand
from tissue_sim.tools.psm import JOINT_NAMES
from tissue_sim.world import World

SEED = 10_005
HOLD = JointCommand(joints=np.tile(HOME_JOINTS, (2, 1)))
RADIUS_M = 0.0015


def bar(**config: float) -> Tubes:
    """Return a straight duct of a duct's materials; ring 0 is fixed."""
    tube = rod(radius_m=RADIUS_M)
    region = np.where(tube.in_lumen, REGIONS.index("duct lumen"), REGIONS.index("duct wall"))
    fixed = np.zeros(len(tube.vertices), bool)
    fixed[tube.rings[0]] = True
    organ = organ_of(
        tube.vertices,
        tube.tets,
        region=region.astype(np.int32),
        fixed=fixed,
        rings={"duct": tube.rings, "artery": np.zeros((1, 13), np.int32)},
        neck_ring={"duct": len(tube.rings) - 1, "artery": 0},
    )
    return Tubes(tissue_of(organ, None, **config), organ)


def mesh_section_m2() -> float:
    """Return the section of the bar's meshed wall: a hexagon minus one of half its size."""
    return 0.75 * 1.5 * np.sqrt(3.0) * RADIUS_M**2


def pulled(tubes: Tubes, newtons: float) -> Array:
    """Return the bar's vertices if its wall alone carries a pull along x and can contract."""
    stress = newtons / mesh_section_m2()
    collagen_pa = stiffness_pa("duct", RADIUS_M, sectors=6, scale=1.0)
    along, across = stretches(stress, MATERIALS["duct wall"], collagen_pa)
    return tubes.organ.vertices * [along, across, across]


def real_strength_n() -> float:
    t = WALL_THICKNESS_M["duct"]
    return STRENGTH_PA["duct"] * np.pi * (RADIUS_M**2 - (RADIUS_M - t) ** 2)


def loaded(tubes: Tubes) -> np.ndarray:
    """Return the (n_segment,) pulls along the duct at its current positions, N."""
    tubes.tissue.load_walls()
    return tubes.tissue.host("segment_pull")[0, 0, : tubes.organ.neck_ring["duct"]].astype(float)


def test_a_wall_carries_its_strength_at_the_stretch_of_failure() -> None:
    """Check it within what the contraction across adds to the soft wall's share."""
    drawn = pulled(bar(), real_strength_n())
    assert np.ptp(drawn[:, 0]) / np.ptp(bar().organ.vertices[:, 0]) == pytest.approx(
        FAILURE_STRETCH, abs=0.01
    )


@pytest.mark.parametrize("turn_rad", [0.0, 1.1])
@pytest.mark.parametrize("share", [0.4, 1.0])
def test_the_pull_in_a_stretched_bar_is_stress_times_section(share: float, turn_rad: float) -> None:
    tubes, newtons = bar(), share * real_strength_n()
    R = axis_angle(unit(np.array([1.0, 2.0, -1.0])), turn_rad)
    put(tubes.tissue, pulled(tubes, newtons) @ R.T)
    np.testing.assert_allclose(loaded(tubes), newtons, rtol=1e-4)


def test_the_pull_is_the_slope_of_the_energy_when_a_segment_lengthens() -> None:
    """Move all vertices beyond one segment along it, in a crumpled bar."""
    tubes, segment, step = bar(), 4, 2e-5
    tissue, rest = tubes.tissue, tubes.organ.vertices
    lumen = tubes.organ.region == REGIONS.index("duct lumen")
    for name in ("mu", "lam"):
        tissue.host(name)[0, : len(lumen)][lumen] = 0.0
    crumpled = rest * [1.5, 0.9, 0.9] + np.random.default_rng(0).normal(0, 1e-4, rest.shape)
    put(tissue, crumpled)
    newtons = loaded(tubes)[segment]
    along = unit(tissue.host("segment_direction")[0, 0, segment].astype(float))
    beyond = tubes.below["duct"][segment + 1 :].ravel()
    energies = []
    for sign in (1.0, -1.0):
        moved = crumpled.copy()
        moved[beyond] += sign * step * along
        put(tissue, moved)
        energies.append(float(tissue.elastic_energy_j()[0]))
    assert newtons == pytest.approx((energies[0] - energies[1]) / (2 * step), rel=2e-3)


def test_a_tangle_has_no_pull() -> None:
    """Check that segments with an inverted element have no pull: its stress has no meaning."""
    tubes = bar()
    x = pulled(tubes, real_strength_n())
    ring, newtons = 4, real_strength_n()
    outer = tubes.below["duct"][ring, 7]
    x[outer] += 3.0 * (x[tubes.below["duct"][ring, 0]] - x[outer])  # through the tube
    put(tubes.tissue, x)
    expected = np.full(8, newtons)
    expected[ring - 1 : ring + 1] = 0.0
    np.testing.assert_allclose(loaded(tubes), expected, rtol=1e-4)


def test_the_pull_in_a_bar_at_rest_under_load_is_the_load() -> None:
    """Check what follows from equilibrium, for any energy.

    The pull leaves out the lumen, which has 1/400 of the section's stiffness. The end rings are
    not checked: they bulge, and the wall's pull is oblique there.
    """
    tubes = bar(step_s=0.002, damping_per_s=2000.0)
    tip, newtons = tubes.below["duct"][-1], 0.8
    tubes.tissue.host("load")[0, tip, 0] = newtons / len(tip)
    for _ in range(300):
        tubes.tissue.step()
    np.testing.assert_allclose(loaded(tubes)[1:-1], newtons, rtol=0.01)


@pytest.mark.parametrize(("share", "tears"), [(0.98, False), (1.02, True)])
def test_a_bar_tears_at_strength_times_real_section(share: float, tears: bool) -> None:
    tubes = bar()
    put(tubes.tissue, pulled(tubes, share * real_strength_n()))
    tubes.tissue.load_walls()
    load = worst_load(tubes, "duct")
    assert load.holds_n == pytest.approx(real_strength_n(), rel=1e-5)
    assert load.pull_n == pytest.approx(share * real_strength_n(), rel=1e-4)
    assert (load.pull_n > load.holds_n) == tears


def test_a_torn_bar_is_in_two_parts_that_recoil() -> None:
    tubes = bar(damping_per_s=5.0)
    put(tubes.tissue, pulled(tubes, 1.1 * real_strength_n()))
    tubes.tissue.load_walls()
    torn = tear(tubes, worst_load(tubes, "duct"), time_s=2.0)
    assert torn is not None
    assert (torn.tube, torn.time_s) == ("duct", 2.0)
    assert torn.pull_n > torn.holds_n
    assert tubes.in_two_parts("duct")
    assert tubes.severed_rings("duct").tolist() == [torn.ring]
    for _ in range(10):
        tubes.tissue.step()
    x = tubes.tissue.positions()
    low, high = (x[side["duct"][torn.ring]].mean(axis=0) for side in (tubes.below, tubes.above))
    assert high[0] - low[0] > 0.002
    assert np.abs(loaded(tubes)).max() < 0.5 * real_strength_n()


def test_a_partial_cut_weakens_the_tube_by_its_share_and_the_tear_starts_there() -> None:
    tubes = bar()
    T = astride(tubes, "duct", tubes.stations_m["duct"][4], beyond_m=0.0)
    (cut,) = sever(tubes, T, time_s=0.0)
    assert not cut.whole
    put(tubes.tissue, np.vstack([pulled(tubes, 1.0), pulled(tubes, 1.0)[_originals(tubes)]]))
    tubes.tissue.load_walls()
    load = worst_load(tubes, "duct")
    wall = (tubes.above["duct"] == tubes.below["duct"])[cut.ring, 1:]
    assert 0 < wall.sum() < len(wall)
    assert load.holds_n == pytest.approx(real_strength_n() * wall.mean(), rel=1e-5)
    assert cut.ring in (load.segment, load.segment + 1)
    torn = tear(tubes, load, time_s=0.0)
    assert torn is not None
    assert torn.ring == cut.ring
    assert tubes.in_two_parts("duct")


def _originals(tubes: Tubes) -> np.ndarray:
    """Return the original of each vertex that a cut added."""
    extra = tubes.above["duct"] != tubes.below["duct"]
    return tubes.below["duct"][extra][np.argsort(tubes.above["duct"][extra])]


def test_a_clips_squeeze_is_not_a_pull_and_the_tube_tears_beside_it(world: World) -> None:
    tubes = world.tubes
    T = astride(tubes, "duct", 0.5 * tubes.length_m["duct"], beyond_m=POLYMER.length_m / 2)
    clip = latch(tubes, T, POLYMER, number=1, time_s=0.0)
    for _ in range(30):
        tubes.tissue.step()
    tubes.tissue.load_walls()
    load = worst_load(tubes, "duct")
    assert load.pull_n < 0.05 * load.holds_n
    ring = clip.crossings[0].ring
    for segment in (ring - 1, ring):
        torn = tear(tubes, replace(load, segment=segment), time_s=0.0)
        assert torn is not None
        assert not np.isin(tubes.below["duct"][torn.ring], clip.vertices).any()
        assert abs(torn.ring - segment) <= 2
    for _ in range(30):
        tubes.tissue.step()
    assert np.isfinite(tubes.tissue.positions()).all()
    assert lumen_shares(tubes, "duct")[ring] < 0.1  # the clip still holds


def test_tears_stop_when_no_spare_vertex_is_left(world: World) -> None:
    tubes = world.tubes
    tubes.tissue.load_walls()
    load, torn = worst_load(tubes, "duct"), []
    for _ in range(20):
        torn.append(tear(tubes, load, time_s=0.0))
        world.step(HOLD)
    rings = [t.ring for t in torn if t is not None]
    assert len(set(rings)) == len(rings) >= 5
    assert torn[-1] is None
    T = astride(tubes, "artery", 0.5 * tubes.length_m["artery"], beyond_m=BLADE_LENGTH_M / 2)
    assert sever(tubes, T, time_s=0.0) == ()  # scissors cannot cut either, and do not raise
    assert np.isfinite(tubes.tissue.positions()).all()


def pull_at_the_neck(world: World, tube: str, newtons: float) -> None:
    """Apply a steady load to the tube's last ring, along the tube."""
    neck = world.tubes.below[tube][world.organ.neck_ring[tube]]
    centres = world.tubes.centres(tube)
    world.tissue.host("load")[0, neck] = newtons * unit(centres[-1] - centres[0]) / len(neck)


@pytest.mark.parametrize("tube", TUBES)
def test_a_tube_pulled_too_hard_tears_and_leaks(world: World, tube: str) -> None:
    strength = worst_load(world.tubes, tube).holds_n
    for newtons in np.arange(0.0, 4.0 * strength, 0.1):  # the sac carries a share
        pull_at_the_neck(world, tube, newtons)
        world.step(HOLD)
        if world.record.tears:
            break
    (torn,) = world.record.tears
    assert torn.tube == tube
    event = next(i for i in world.record.injuries if i.event == f"avulsion of {tube}")
    assert (event.value, event.limit) == (torn.pull_n, torn.holds_n)
    assert event.limit == pytest.approx(strength)
    assert strength < event.value < 1.1 * strength
    assert newtons > 0.9 * strength
    assert {x.side for x in world.record.leaks if x.structure == tube} == {"body", "gallbladder"}
    assert any(i.event == "leak" for i in world.record.injuries)
    assert world.observe().severed.any()


def test_a_tear_is_not_a_cut(world: World) -> None:
    tubes = world.tubes
    length = tubes.length_m["duct"]
    clips = []
    for station in (0.003, 0.0072, length - 0.0045):
        T = astride(tubes, "duct", station, beyond_m=POLYMER.length_m / 2)
        clips.append(latch(tubes, T, POLYMER, number=len(clips) + 1, time_s=0.0))
        for _ in range(30):
            tubes.tissue.step()
    world.record = replace(world.record, clips=tuple(clips))
    T = astride(tubes, "duct", 0.5 * (0.0072 + length - 0.0045), beyond_m=BLADE_LENGTH_M / 2)
    whole = world.state()
    world.record = replace(world.record, cuts=sever(tubes, T, time_s=0.0))
    assert tube_cut(world, "duct")
    (cut,) = world.record.cuts
    torn = Tear(tube="duct", time_s=0.0, ring=cut.ring, station_m=0.0, pull_n=9.0, holds_n=8.0)
    world.record = replace(world.record, tears=(torn,))
    assert not tube_cut(world, "duct")
    world.restore(whole)
    tubes.tissue.load_walls()
    torn = tear(tubes, replace(worst_load(tubes, "duct"), segment=cut.ring), time_s=0.0)
    assert torn is not None
    world.record = replace(world.record, tears=(torn,))
    assert tubes.in_two_parts("duct")
    assert not tube_cut(world, "duct")
    assert leaks(tubes, clips, world.record.openings) == ()  # clips hold on both sides of the tear
    assert {x.side for x in leaks(tubes, (), world.record.openings)} == {"body", "gallbladder"}


def test_each_patch_of_the_sac_spans_the_walls_thickness(world: World) -> None:
    organ, pieces = world.organ, wall_pieces(world.organ)
    of_sac = (pieces[:, 0] == SAC) & (pieces[:, 1] >= 0)
    np.testing.assert_array_equal(of_sac, organ.region == REGIONS.index("gallbladder wall"))
    assert (np.bincount(pieces[of_sac, 1]) == 6).all()
    assert pieces[of_sac, 1].max() == n_patches(organ) - 1
    tubes = pieces[pieces[:, 0] != SAC]
    assert set(np.unique(tubes[:, 0])) == set(range(len(organ.hollow)))


def test_a_patch_tears_when_the_real_wall_would_be_stretched_too_far(world: World) -> None:
    stiffness = patch_stiffness(world.organ)
    worst, rest = int(np.argmax(stiffness)), world.organ.vertices
    needed = 1.0 + (SAC_MAX_STRETCH - 1.0) / stiffness[worst]
    for share, tears in ((0.99, False), (1.01, True)):
        along = 1.0 + share * (needed - 1.0)
        put(world.tissue, rest * [along, 1.0, 1.0])
        world.tissue.load_walls()
        assert (world.sac.stretch() > SAC_MAX_STRETCH) == tears
    assert world.sac.stretch() == pytest.approx(1.0 + (along - 1.0) * stiffness[worst], rel=1e-3)
    world.sac.tear()
    (opened,) = world.sac.open_patches()
    assert stiffness[opened] == pytest.approx(stiffness[worst], rel=1e-3)


def test_the_stretch_of_a_patch_is_the_largest_singular_value(world: World) -> None:
    rng = np.random.default_rng(0)
    stiffness, rest = patch_stiffness(world.organ), world.organ.vertices
    for F in (np.eye(3), np.diag([1.3, 1.3, 0.6]), *np.eye(3) + 0.4 * rng.normal(size=(5, 3, 3))):
        put(world.tissue, rest @ F.T)
        world.tissue.load_walls()
        longest = np.linalg.svd(F, compute_uv=False)[0]
        np.testing.assert_allclose(
            world.tissue.host("patch_stretch")[0, : len(stiffness)],
            1.0 + (longest - 1.0) * stiffness,
            atol=2e-3,
        )


def test_each_tear_opens_another_patch_as_a_removed_wall_is_not_stretched(
    world: World,
) -> None:
    put(world.tissue, world.organ.vertices * [4.0, 1.0, 1.0])
    for n_torn in range(1, 4):
        world.tissue.load_walls()
        assert world.sac.stretch() > SAC_MAX_STRETCH
        world.sac.tear()
        assert len(world.sac.open_patches()) == n_torn


def test_a_hole_has_the_area_of_the_removed_wall(world: World) -> None:
    tissue, sac = world.tissue, world.sac
    assert sac.hole_m2() == 0.0
    assert hole_leak(sac) == ()
    alive = tissue.host("tet_alive")[0, : len(world.organ.tets)]
    mass = tissue.host("mass")[0].astype(float).sum()
    patches = np.arange(63, 66, dtype=np.int32)
    sac.open(patches)
    np.testing.assert_array_equal(sac.open_patches(), patches)
    gone = tissue.host("volume")[0, : len(alive)][alive == 0].astype(float).sum()
    lost = mass - tissue.host("mass")[0].astype(float).sum()
    assert lost == pytest.approx(DENSITY_KG_M3 * gone, rel=1e-3)
    skin = build_skin(
        tissue.tets()[alive != 0],
        world.organ.region[alive != 0],
        surface_faces(world.organ.tets)[alive != 0],
        tissue.n_vertex(),
    )
    corners = tissue.positions()[skin.patches[CUT_LUMEN].coarse].astype(float)
    edges = corners[:, 1:] - corners[:, :1]
    seen = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum()
    # the quadrilaterals are not flat: half the diagonals' product differs from two triangles
    assert sac.hole_m2() == pytest.approx(seen, rel=0.05)
    put(tissue, 2.0 * tissue.positions())
    assert sac.hole_m2() == pytest.approx(4.0 * seen, rel=0.05)


def test_bile_leaks_through_the_hole_until_the_sac_is_empty(world: World) -> None:
    world.sac.open(np.array([63, 64]))
    way = FlowSegment(length_m=WALL_THICKNESS_M["gallbladder"], area_m2=world.sac.hole_m2())
    (leak,) = hole_leak(world.sac, fullness=0.5)
    assert leak.rate_m3_s == pytest.approx(outflow_m3_s(BILE, 0.5 * BILE_PRESSURE_PA, [way]))
    for _ in range(3):
        world.step(HOLD)
    r = world.record
    assert 0.0 < r.drained_m3 == r.leaked_m3 < world.sac.contents_m3
    world.record = replace(r, drained_m3=world.sac.contents_m3)
    world.step(HOLD)
    assert world.record.leaked_m3 == r.leaked_m3


def test_a_removed_wall_leaves_no_falling_vertices(world: World) -> None:
    before = world.state()
    world.sac.open(np.arange(n_patches(world.organ), dtype=np.int32))
    gone = np.setdiff1d(world.organ.sac_rings[:, 11:], world.organ.tie_corners)
    place = world.tissue.positions()[gone].copy()
    for _ in range(30):
        world.step(HOLD)
    np.testing.assert_array_equal(world.tissue.positions()[gone], place)
    assert np.isfinite(world.tissue.positions()).all()
    world.restore(before)
    fixed = world.tissue.host("fixed")[0, : len(world.organ.fixed)] != 0
    np.testing.assert_array_equal(fixed, world.organ.fixed)


def on_the_sac(world: World, beyond_m: float) -> Array:
    """Return `T_world_tool` of blades that meet on the body's front, across its axis."""
    rings = world.organ.sac_rings
    x = world.tissue.positions().astype(float)
    outer = x[rings[5:7, 11:]].reshape(-1, 3)
    front = outer[np.argmin(outer @ AWAY)]
    along = unit(x[rings[7, 0]] - x[rings[4, 0]])
    z = unit(AWAY - (AWAY @ along) * along)
    return pose(np.stack([along, np.cross(z, along), z], axis=1), front + beyond_m * z)


def test_blades_open_the_patches_where_they_meet(world: World) -> None:
    T = on_the_sac(world, 0.001)
    slit = world.sac.under_blades(T, BLADE_LENGTH_M)
    assert 1 <= len(slit) <= 6
    assert world.sac.under_blades(on_the_sac(world, -0.002), BLADE_LENGTH_M).size == 0
    assert world.sac.under_blades(on_the_sac(world, 0.1), BLADE_LENGTH_M).size == 0
    world.sac.open(slit)
    assert world.sac.under_blades(T, BLADE_LENGTH_M).size == 0


@pytest.mark.parametrize(
    ("kind", "event"),
    [
        ("tie", "tear of duct from gallbladder"),
        ("anchor", "detachment from liver bed"),
        ("ligament", "tear of the ligament"),
    ],
)
def test_a_broken_attachment_is_an_injury(world: World, kind: str, event: str) -> None:
    row = len(world.organ.bed_vertices) if kind == "ligament" else 0
    world.step(HOLD)
    assert world.record.injuries == ()
    world.tissue.host(f"{kind.replace('ligament', 'anchor')}_stiffness")[0, row] = 0.0
    world.step(HOLD)
    (injury,) = world.record.injuries
    assert (injury.event, injury.value, injury.limit) == (event, 1, 0)


@pytest.mark.parametrize("excess", [0.99, 1.01])
def test_what_cannot_be_done_by_hand_here_is_read_and_limited(world: World, excess: float) -> None:
    """Check the pinch, the gallbladder's wall and the joints, just below and above the limits."""
    grasp = Grasp(pinch_n=excess * PINCH_MAX_N)
    world.tissue.host("patch_stretch")[0, 3] = 1.0 + excess * (SAC_MAX_STRETCH - 1.0)
    readings = [
        *other_readings(world, world.record, grasp, excess * JOINT_MARGIN_RAD),
        *wall_loads(world, ()),
    ]
    hurt = {reading.event for reading in readings if reading.value > reading.limit}
    assert hurt == ({"pinch", "joint limit", "tear of gallbladder"} if excess > 1.0 else set())


def test_a_command_beyond_a_joints_limit_is_an_injury(world: World) -> None:
    beyond = np.tile(HOME_JOINTS, (2, 1))
    beyond[RIGHT_ARM, JOINT_NAMES.index("insertion")] = 0.25  # it ends at 0.24 m
    world.step(HOLD)
    world.step(JointCommand(joints=beyond))
    assert "joint limit" in [injury.event for injury in world.record.injuries]


def test_the_sac_pressed_on_the_liver_is_an_injury(world: World) -> None:
    """Press on the part of the sac that lies on the bed: a load of 4 N is an injury, 1 N is not."""
    lying, n = world.organ.bed_vertices, world.organ.bed.normal
    for newtons in (1.0, 4.0):
        world.tissue.host("load")[0, lying] = -newtons * n / len(lying)
        for _ in range(40):
            world.step(HOLD)
        events = [i.event for i in world.record.injuries]
        assert events == (["liver force through gallbladder"] if newtons > 2.0 else [])
