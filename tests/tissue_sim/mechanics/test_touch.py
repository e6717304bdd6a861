"""Tests of contact: the bed carries weight, pushes are mutual, friction has its cone."""

import numpy as np
import pytest

from tests.tissue_sim.bodies import forces
from tests.tissue_sim.verification.bodies import EPS, FAR_BED, box, organ_of, put, tissue_of
from tissue_sim.frames import AWAY, Array, axis_angle, pose, transform, unit
from tissue_sim.mechanics.layout import N_SHAPES
from tissue_sim.mechanics.step import TissueConfig
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.touch import BED_STIFFNESS, NORMAL_STIFFNESS, STICK_STIFFNESS
from tissue_sim.patient.organ import TUBE_SECTORS, TUBES, build_organ
from tissue_sim.patient.supports import LiverBed
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.surgery.grasp import LEFT_FINGERS, Grasp, follow_grasp
from tissue_sim.thresholds import GRASP_MAX_SLIP_M
from tissue_sim.tools.instruments import INSTRUMENTS, link_patches
from tissue_sim.verification.statics import equilibrium, statics_of

CAPSULE, CAPSULE_RADIUS_M = 4, 0.003
T_WORLD_LINK = pose(axis_angle([1.0, 1.0, 0.0], 0.4), np.array([0.05, -0.02, 0.03]))


def place(tissue: Tissue, rows: dict[int, dict[str, Array | float]]) -> None:
    """Put some contact shapes into the field and all others out of it."""
    out = {
        "a": np.full((N_SHAPES, 3), 9.0),
        "b": np.full((N_SHAPES, 3), 9.0),
        "half_width": np.zeros((N_SHAPES, 3)),
        "radius": np.zeros(N_SHAPES),
        "friction": np.zeros(N_SHAPES),
        "T_world_link": np.tile(np.eye(4), (N_SHAPES, 1, 1)),
        "T_world_link_before": np.tile(np.eye(4), (N_SHAPES, 1, 1)),
    }
    for row, values in rows.items():
        for name, value in {"T_world_link_before": values["T_world_link"], **values}.items():
            out[name][row] = value
    tissue.place_tools(0, **out)


def touching(tissue: Tissue) -> Array:
    return tissue.host("contact_shape")[0, : tissue.n_vertex()]


def felt(tissue: Tissue) -> Array:
    """Return the (n, 3) force of the instruments on each vertex."""
    f = tissue.host("contact_force")[0, : tissue.n_vertex()].astype(float)
    return np.where(touching(tissue)[:, None] >= 0, f, 0.0)


def test_a_body_on_the_bed_comes_to_rest_where_the_bed_carries_its_weight() -> None:
    axis = unit(np.array([1.0, 2.0, 10.0]))
    R = np.stack([unit(np.cross([0.0, 1.0, 0.0], axis)), np.zeros(3), axis], axis=1)
    R[:, 1] = np.cross(axis, R[:, 0])
    # it sinks in by 0.15 mm, more than the 0.04 mm it falls in a step
    rest, tets = box((0.03,) * 3, (3, 3, 3))
    bed = LiverBed(point_m=np.zeros(3), normal=axis, along=R[:, 0], edge_m=-1.0)
    tissue = tissue_of(
        organ_of(rest @ R.T + 1e-5 * axis, tets, bed=bed),
        gravity_m_s2=tuple(-9.81 * axis), damping_per_s=100.0, step_s=1 / 480,
    )  # fmt: skip
    for _ in range(400):
        tissue.step()
    weight = 9.81 * tissue.host("mass").sum()
    assert np.abs(tissue.host("velocity")).max() < 1e-5
    height = tissue.positions() @ axis
    assert -BED_STIFFNESS * np.minimum(height, 0.0).sum() == pytest.approx(weight, rel=1e-2)
    assert tissue.host("bed_force")[0] @ axis == pytest.approx(weight, rel=1e-2)
    assert np.abs(tissue.host("bed_force")[0] @ R[:, :2]).max() < 1e-3 * weight


def test_tissue_held_in_the_bed_comes_to_rest_at_the_worlds_step() -> None:
    """Hold the lower side 2 mm deep with springs of 60 N/m; the bed must not throw it out."""
    rest, tets = box((0.01,) * 3, (2, 2, 2))
    below = np.flatnonzero(rest[:, 2] == 0.0).astype(np.int32)
    bed = LiverBed(**(vars(FAR_BED) | {"point_m": np.array([0.0, 0.0, 0.002])}))
    tissue = Tissue([organ_of(rest, tets, bed=bed, bed_vertices=below)])
    for _ in range(120):
        tissue.step()
    static = equilibrium(statics_of(tissue), rest)
    assert static[below, 2].max() < 0.002  # the lower side is in the bed
    # the solver leaves micrometres; a vertex that is thrown out moves by a millimetre
    assert np.abs(tissue.positions() - static).max() < 1e-5


@pytest.mark.parametrize("size", [(0.03, 0.03, 0.02), (0.01, 0.01, 0.002)])
def test_a_light_body_does_not_bounce_on_the_bed_at_the_step_of_the_world(
    size: tuple[float, float, float],
) -> None:
    rest, tets = box(size, (4, 4, 2))
    bed = LiverBed(**(vars(FAR_BED) | {"point_m": np.zeros(3)}))
    config = TissueConfig()
    tissue = tissue_of(
        organ_of(rest + 1e-3 * bed.normal, tets, bed=bed),
        gravity_m_s2=config.gravity_m_s2, damping_per_s=config.damping_per_s,
        iterations=config.iterations, tolerance=config.tolerance,
    )  # fmt: skip
    for _ in range(240):
        tissue.step()
    assert np.abs(tissue.host("velocity")).max() < 1e-4


def test_tissue_beside_the_bed_keeps_falling() -> None:
    rest, tets = box((0.002,) * 3, (1, 1, 1))
    bed = LiverBed(**(vars(FAR_BED) | {"point_m": np.zeros(3), "edge_m": 0.005}))
    tissue = tissue_of(organ_of(rest, tets, bed=bed), gravity_m_s2=(0.0, 0.0, -9.81))
    for _ in range(10):
        tissue.step()
    assert not tissue.host("bed_force").any()
    assert tissue.positions()[:, 2].max() < -0.1


@pytest.fixture(scope="module")
def pressed() -> Tissue:
    """Press a capsule 1.5 mm into a block that is held below, and drag it a little."""
    rest, tets = box((0.02, 0.02, 0.01), (6, 6, 3))
    tissue = tissue_of(organ_of(rest, tets, fixed=rest[:, 2] == 0), damping_per_s=20.0)
    for k in range(150):
        lower, drag = 0.0015 * min(k / 60, 1.0), 0.0004 * np.clip((k - 60) / 40, 0.0, 1.0)
        put_capsule(tissue, 0.01 + CAPSULE_RADIUS_M - lower, drag)
        tissue.step()
    return tissue


def put_capsule(tissue: Tissue, height_m: float, drag_m: float = 0.0) -> None:
    T = T_WORLD_LINK.copy()
    T[0, 3] += drag_m
    ends = np.array([[drag_m - 0.01, 0.0105, height_m], [drag_m + 0.03, 0.0105, height_m]])
    place(
        tissue,
        {CAPSULE: {"a": ends[0], "b": ends[1], "radius": CAPSULE_RADIUS_M, "friction": 0.3,
                   "T_world_link": T}},
    )  # fmt: skip


def test_an_instrument_pushes_tissue_out(pressed: Tissue) -> None:
    """Check that each touched vertex is as deep as its force over the contact's stiffness."""
    axis = pressed.shapes.a.numpy()[0, CAPSULE]
    off = pressed.positions()[:, 1:] - axis[1:]
    depth = CAPSULE_RADIUS_M - np.linalg.norm(off, axis=1)
    held = touching(pressed) == CAPSULE
    assert held.sum() >= 5
    assert depth[held].max() < 0.0003  # of the 1.5 mm that the capsule was lowered
    np.testing.assert_array_equal(depth > 0, held)
    normal = off[held] / np.linalg.norm(off[held], axis=1, keepdims=True)
    push = (felt(pressed)[held][:, 1:] * normal).sum(axis=1)
    assert (push > 0).all()
    rounding_n = float(NORMAL_STIFFNESS) * 8 * EPS * 0.03
    np.testing.assert_allclose(push, NORMAL_STIFFNESS * depth[held], rtol=1e-2, atol=rounding_n)


def test_instrument_and_tissue_feel_opposite_forces_and_torques(pressed: Tissue) -> None:
    force, torque = (w[CAPSULE].astype(float) for w in pressed.tool_wrenches())
    f = felt(pressed)
    arms = pressed.positions() - pressed.shapes.T_world_link.numpy()[0, CAPSULE, :3, 3]
    assert np.linalg.norm(force) > 0.1
    rounding = 50 * EPS * np.abs(f).sum()
    np.testing.assert_allclose(force, -f.sum(axis=0), atol=rounding)
    np.testing.assert_allclose(
        torque, -np.cross(arms, f).sum(axis=0), atol=rounding * np.abs(arms).max()
    )
    others = np.delete(pressed.tool_wrenches()[0][0:N_SHAPES], CAPSULE, axis=0)
    assert not others.any()


def test_at_rest_the_held_side_carries_the_instruments_force(pressed: Tissue) -> None:
    """Check the statics: the elastic force at the fixed side balances the contact force."""
    velocity = np.abs(pressed.host("velocity")).max()
    assert velocity < 1e-5
    before = pressed.state()
    carried = forces(pressed, "elements")[pressed.host("fixed")[0, : pressed.n_vertex()] != 0]
    pressed.restore(before)
    total = felt(pressed).sum(axis=0)
    np.testing.assert_allclose(carried.sum(axis=0), total, atol=1e-2 * np.linalg.norm(total))


def test_friction_never_leaves_its_cone_and_sticks_inside_it(pressed: Tissue) -> None:
    axis = pressed.shapes.a.numpy()[0, CAPSULE]
    held = touching(pressed) == CAPSULE
    off = pressed.positions()[held] - axis
    off[:, 0] = 0.0
    normal = unit(off.astype(float))
    f = felt(pressed)[held]
    along = (f * normal).sum(axis=1)
    tangential = np.linalg.norm(f - along[:, None] * normal, axis=1)
    # forces come from the linearised step: at rest they differ from the cone by rounding
    assert (tangential <= 0.3 * along * 1.01 + 1e-5).all()
    assert tangential.max() > 0.01  # the drag causes friction
    # inside the cone the tissue sticks to its place, and the sticking spring pulls it
    T = pressed.shapes.T_world_link.numpy()[0, CAPSULE].astype(float)
    stuck = transform(T, pressed.host("stick_point")[0, : pressed.n_vertex()][held].astype(float))
    slip = pressed.positions()[held] - stuck
    slip -= (slip * normal).sum(axis=1, keepdims=True) * normal
    inside = tangential < 0.25 * along
    assert inside.any()
    expected = float(STICK_STIFFNESS) * np.linalg.norm(slip, axis=1)
    np.testing.assert_allclose(tangential[inside], expected[inside], rtol=0.05, atol=2e-4)


def test_tissue_without_contact_has_no_contact_force() -> None:
    tissue = tissue_of(organ_of(*box((0.01,) * 3, (2, 2, 2))))
    put_capsule(tissue, 0.1)
    tissue.step()
    assert (touching(tissue) == -1).all()
    assert not tissue.tool_wrenches()[0].any()


GRASPER = INSTRUMENTS["grasper"]
GRASPER_FRICTION = 0.7


def put_grasper(tissue: Tissue, T_world_tool: Array, jaw_rad: float, friction: float) -> None:
    """Place the grasper's two fingers, each turned about its joint by half the jaw's opening."""
    patches = link_patches(GRASPER)
    rows = {}
    for row, sign in zip(LEFT_FINGERS, (1.0, -1.0), strict=True):
        T = T_world_tool.copy()
        T[:3, 3] -= GRASPER.yaw_to_tip_m * T_world_tool[:3, 2]
        T[:3, :3] = T[:3, :3] @ axis_angle([1.0, 0.0, 0.0], -sign * jaw_rad / 2)
        rows[row] = {
            "a": transform(T, patches.a_link_m[row][None])[0],
            "b": transform(T, patches.b_link_m[row][None])[0],
            "half_width": T[:3, :3] @ patches.w_link_m[row],
            "radius": patches.radius_m[row],
            "friction": friction,
            "T_world_link": T,
        }
    place(tissue, rows)


SIDE_M = 0.012
FACE_MIDDLE_M = np.array([SIDE_M, SIDE_M / 2, SIDE_M / 2])  # of the block's face at its largest x


def block() -> Tissue:
    """Return a block of 2 mm elements, held at its face x = 0."""
    rest, tets = box((SIDE_M,) * 3, (6, 6, 6))
    return tissue_of(organ_of(rest, tets, fixed=rest[:, 0] == 0))


@pytest.mark.parametrize("finger", LEFT_FINGERS)
def test_closed_jaws_that_press_sideways_act_as_one_body(finger: int) -> None:
    """Check that tissue that touches the outside of one finger is not drawn to the other."""
    tissue = block()
    y = np.array([-1.0 if finger == LEFT_FINGERS[0] else 1.0, 0.0, 0.0])  # finger towards block
    R = np.stack([[0.0, 0.0, 1.0], y, np.cross([0.0, 0.0, 1.0], y)], axis=1)
    thickness = 2 * GRASPER.finger_half_thickness_m
    tip = FACE_MIDDLE_M + 0.008 * R[:, 2] + [thickness - 0.0003, 0.0, 0.0]
    put_grasper(tissue, pose(R, tip), 0.0, 0.0)
    touched = set()
    for _ in range(20):
        tissue.step()
        touched.update(touching(tissue)[touching(tissue) >= 0])
        assert felt(tissue)[:, 0].max() <= 0.0
    assert touched == {finger}


@pytest.mark.parametrize("swept", [False, True])
def test_a_finger_pushes_the_tissue_that_it_sweeps_over_in_one_step(*, swept: bool) -> None:
    """Compare with a finger that is placed there: behind the face it touches nothing."""
    tissue = block()
    now = pose(np.eye(3), FACE_MIDDLE_M - [0.001, 0.0, 0.0])
    before = pose(np.eye(3), np.add(FACE_MIDDLE_M, [0.002, 0.0, 0.0]))
    finger = {
        "a": now[:3, 3] - [0.0, 0.0, 0.0045],
        "b": now[:3, 3] + [0.0, 0.0, 0.0045],
        "half_width": np.array([0.0, 0.0025, 0.0]),
        "radius": 0.0008,
        "T_world_link": now,
    }
    place(tissue, {LEFT_FINGERS[0]: finger | ({"T_world_link_before": before} if swept else {})})
    at_face = tissue.positions()[:, 0] == np.float32(SIDE_M)
    tissue.step()
    touched = touching(tissue) >= 0
    assert touched.any() == swept
    assert (felt(tissue)[touched, 0] < 0.0).all()
    np.testing.assert_array_equal(touched & ~at_face, False)


def test_a_tube_that_a_finger_ran_into_leaves_it_on_one_side() -> None:
    organ = build_organ(textbook_from_seed(1))
    tissue = Tissue([organ])
    rings = organ.rings["duct"][8:13]
    x = tissue.positions()[rings].astype(float)
    along, middle = unit(x[-1, 0] - x[0, 0]), x[2, 0]
    across = unit(np.cross(along, AWAY))
    finger = {
        "a": middle - 0.008 * across,
        "b": middle + 0.008 * across,
        "half_width": 0.0025 * along,
        "radius": 0.0012,
        "T_world_link": pose(np.eye(3), middle),
    }
    place(tissue, {LEFT_FINGERS[0]: finger})
    over = unit(np.cross(across, along))
    assert {-1.0, 1.0} <= set(sides(tissue, rings, middle, over))
    for _ in range(30):
        tissue.step()
    assert len(set(sides(tissue, rings, middle, over))) == 1
    assert (tissue.volumes() > 0).all()


def sides(tissue: Tissue, rings: Array, middle: Array, over: Array) -> Array:
    """Return the side of a finger on which each vertex of some rings lies."""
    return np.sign((tissue.positions()[rings[1:-1].ravel()] - middle) @ over)


def pulled_by(friction: float, jaw_rad: float, pull_m: float) -> tuple[Grasp, float, float]:
    """Grasp the infundibulum and pull it; return the hold and the paths of tissue and tool."""
    organ = build_organ(textbook_from_seed(1))
    tissue = Tissue([organ])
    ring = organ.sac_rings[5]
    centre = organ.vertices[ring[0]]
    along = unit(organ.vertices[organ.sac_rings[6, 0]] - organ.vertices[organ.sac_rings[4, 0]])
    z = unit(AWAY - (AWAY @ along) * along)
    T = pose(np.stack([along, np.cross(z, along), z], axis=1), centre + 0.006 * z)
    grasp, time_s = Grasp(), 0.0
    start = np.zeros(3)
    for k in range(220):
        close = np.clip(k / 60, 0.0, 1.0)
        moved = pull_m * np.clip((k - 80) / 100, 0.0, 1.0)
        now = T.copy()
        now[:3, 3] -= moved * z
        put_grasper(tissue, now, 0.9 + close * (jaw_rad - 0.9), friction)
        tissue.step()
        time_s += tissue.config.step_s
        grasp = follow_grasp(grasp, tissue, organ, now, time_s)
        if k == 80:
            start = tissue.positions()[ring].mean(axis=0).astype(float)
    came = float((start - tissue.positions()[ring].mean(axis=0)) @ z)
    return grasp, came, pull_m


def test_a_grasp_below_the_friction_limit_holds_and_above_it_slips() -> None:
    pull = 0.006
    held, came, _ = pulled_by(GRASPER_FRICTION, 0.10, pull)
    assert held.vertices
    assert came > 0.7 * pull
    assert held.traction_n <= 2 * GRASPER_FRICTION * held.pinch_n * 1.2
    slipped, came_slippery, _ = pulled_by(0.01, 0.10, pull)
    assert came_slippery < 0.5 * came
    assert slipped.traction_n < 0.5 * held.traction_n


def test_an_open_grasper_holds_nothing() -> None:
    grasp, came, pull = pulled_by(GRASPER_FRICTION, 0.9, 0.006)
    assert not grasp.vertices
    assert abs(came) < 0.2 * pull


@pytest.mark.parametrize(("share", "slips"), [(0.98, False), (1.02, True)])
def test_a_slip_by_the_threshold_restarts_the_grasp(share: float, slips: bool) -> None:
    """Check that slip is measured along the jaws' surface; a squeeze across it is not slip."""
    organ = build_organ(textbook_from_seed(1))
    tissue = Tissue([organ])
    touching_now = tissue.host("contact_shape")[0]
    for finger, ring in zip(LEFT_FINGERS, organ.sac_rings[3:5], strict=True):
        touching_now[ring[-4:]] = finger
    before = follow_grasp(Grasp(), tissue, organ, np.eye(4), 1.0)
    assert (before.since_s, before.slip_m) == (1.0, 0.0)
    assert len(before.vertices) == 8
    moved = pose(np.eye(3), np.array([0.6, 0.0, 0.8]) * share * GRASP_MAX_SLIP_M)
    moved[1, 3] = 2.0 * GRASP_MAX_SLIP_M
    after = follow_grasp(before, tissue, organ, moved, 2.0)
    assert after.slip_m == pytest.approx(share * GRASP_MAX_SLIP_M, rel=1e-3)
    assert after.since_s == (2.0 if slips else 1.0)
    again = follow_grasp(after, tissue, organ, moved, 3.0)
    assert again.slip_m == pytest.approx(0.0 if slips else share * GRASP_MAX_SLIP_M, abs=1e-9)


def nearest_on_line(points: Array, line: Array) -> Array:
    """Return the (n, 3) nearest point of a polyline to each point."""
    a, u = line[:-1], np.diff(line, axis=0)
    share = np.einsum("nkx,kx->nk", points[:, None] - a, u) / (u**2).sum(axis=1)
    feet = a + np.clip(share, 0.0, 1.0)[..., None] * u
    best = np.linalg.norm(points[:, None] - feet, axis=-1).argmin(axis=1)
    return feet[np.arange(len(points)), best]


def deepest_share(seed: int, *, contact: bool) -> float:
    """Return the largest depth of the artery's wall in the duct, over the duct's radius.

    A force of 0.3 N presses the artery's middle against the duct.
    """
    organ = build_organ(textbook_from_seed(seed))
    tissue = Tissue([organ])
    tissue.host("link_stiffness")[:] = 0.0
    tissue.host("collagen")[:] = 0.0  # or it would keep the artery from the duct
    if not contact:
        del tissue.stages["tube contact"]
    duct, artery = (organ.rings[t][: organ.neck_ring[t] + 1] for t in TUBES)
    radius = float(tissue.host("tube_radius")[0, 0])
    middle = artery[len(artery) // 2]
    towards, deepest = np.zeros(3), -np.inf
    for k in range(300):
        x = tissue.positions().astype(float)
        line, outer = x[duct[:, 0]], x[artery[:, 1 + TUBE_SECTORS :].ravel()]
        if deepest < 0:  # after the first contact the direction stays the same
            towards = unit(nearest_on_line(x[middle[:1]], line)[0] - x[middle[0]])
        apart = np.linalg.norm(outer - nearest_on_line(outer, line), axis=1).min()
        deepest = max(deepest, 1 - apart / radius)
        tissue.host("load")[0][:] = 0.0
        tissue.host("load")[0][middle] = 0.3 * min(k / 240, 1.0) * towards / len(middle)
        tissue.step_in_stages()
    return float(deepest)


@pytest.mark.parametrize("seed", [3, 8, 31])
def test_duct_and_artery_do_not_pass_through_each_other(seed: int) -> None:
    assert 0.0 < deepest_share(seed, contact=True) < 0.3
    assert (
        deepest_share(seed, contact=False) > 0.8
    )  # without contact this force pushes the artery through


def test_artery_and_duct_push_each_other_with_opposite_forces() -> None:
    organ = build_organ(textbook_from_seed(0))
    tissue = tissue_of(organ, None)
    duct, artery = (organ.rings[t] for t in TUBES)
    x = organ.vertices.copy()
    to = x[duct[6, 0]] - x[artery[6, 0]]
    reach = np.linalg.norm(to) - float(tissue.host("tube_radius")[0, :2].sum()) + 3e-4
    x[artery] += reach * unit(to)
    put(tissue, x)
    f = forces(tissue, "tube contact")
    assert np.abs(f).max() > 0.01
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=50 * EPS * np.abs(f).sum())
    assert (f[artery[6]].sum(axis=0)) @ to < 0 < (f[duct].sum(axis=(0, 1))) @ to


def test_a_tubes_end_within_the_sac_can_be_touched_only_after_it_is_torn_out() -> None:
    """Check that a ball touches the duct's last ring only after the duct is torn out."""
    organ = build_organ(textbook_from_seed(1))
    tissue = Tissue([organ])
    ring = organ.rings["duct"][-1]
    outer = ring[-(len(ring) // 2) :]
    assert not contact_of(tissue, outer).any()
    torn = np.isin(organ.tie_vertex, organ.rings["duct"][1:])
    tissue.host("tie_stiffness")[0, : len(torn)][torn] = 0.0
    tissue.rewire(0)
    assert contact_of(tissue, outer).any()


def contact_of(tissue: Tissue, vertices: Array) -> Array:
    """Return which vertices touch a ball at their mean position."""
    middle = tissue.positions()[vertices].mean(axis=0).astype(float)
    ball = {
        "a": middle,
        "b": middle,
        "half_width": np.zeros(3),
        "radius": 0.004,
        "T_world_link": pose(np.eye(3), middle),
    }
    place(tissue, {LEFT_FINGERS[0]: ball})
    tissue.step()
    return tissue.host("contact_shape")[0, vertices] >= 0
