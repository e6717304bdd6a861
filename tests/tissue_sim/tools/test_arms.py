"""Tests of the arms on a real simulator scene: kinematics, stiffness, contact, save and restore."""

import numpy as np
import pytest
import sapien

from tissue_sim.frames import AWAY, RIGHT, UP, axis_angle, inverse_pose
from tissue_sim.tools.arms import ASSISTANT, HOME_JOINTS, LIVER, RIGHT_ARM, Arms
from tissue_sim.tools.instruments import INSTRUMENTS, right_tools
from tissue_sim.tools.psm import forward_kinematics, joint_limits

DT_S = 1 / 120
FINGER_PLUS = np.array([2, 6])  # rows of the contact shapes
FINGER_MINUS = np.array([3, 7])
SHAFT = np.array([0, 4])
# A float32 pose composed over nine links, each entry at most 1: a few roundings of 6e-8 a link.
FLOAT32_CHAIN = 9 * 4 * 2.0**-24


@pytest.fixture(params=["tgs", "pgs"])
def scene(request):
    """Yield a scene without renderer, under each of the simulator's two solvers."""
    config = sapien.physx.get_scene_config()
    default = config.enable_tgs
    config.enable_tgs = request.param == "tgs"
    sapien.physx.set_scene_config(config)
    yield new_scene()
    config.enable_tgs = default
    sapien.physx.set_scene_config(config)


only_pgs = pytest.mark.parametrize("scene", ["pgs"], indirect=True)  # see Arms on velocities


def new_scene():
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    scene.set_timestep(DT_S)
    return scene


@pytest.fixture
def arms(scene):
    return Arms(scene, render=False)


def home(**columns):
    names = ("yaw", "pitch", "insertion", "roll", "wrist_pitch", "wrist_yaw", "jaw")
    joints = np.tile(HOME_JOINTS, (2, 1))
    for name, value in columns.items():
        joints[:, names.index(name)] = value
    return joints


def command(arms, joints):
    """Set joint targets (2, 7) as a control step of the world does."""
    arms.settle()
    arms.drive(arms.limited(joints))


def random_joints(rng, arms):
    rows = []
    for instrument in arms.mounted:
        lower, upper = joint_limits(instrument).T
        jaw = rng.uniform(0, instrument.jaw_range_rad[1])
        rows.append([*rng.uniform(lower, upper), jaw])
    return np.array(rows)


def step(scene, n):
    for _ in range(n):
        scene.step()


@pytest.mark.parametrize("right", ["clip_applier", "scissors"])
def test_tool_poses_are_those_of_the_dh_table(arms, right):
    arms.mount(right)
    rng = np.random.default_rng(0)
    for _ in range(200):
        joints = random_joints(rng, arms)
        arms.set_joints(joints)
        for arm, T_world_tool in enumerate(arms.T_world_tool()):
            T_rcm_tool = forward_kinematics(joints[arm, :6], arms.mounted[arm])
            expected = arms.T_world_rcm[arm] @ T_rcm_tool
            np.testing.assert_allclose(T_world_tool, expected, atol=FLOAT32_CHAIN)


def test_shafts_pass_through_their_ports(arms, scene):
    rng = np.random.default_rng(1)
    ports = arms.T_world_rcm[:, :3, 3]
    for _ in range(50):
        arms.set_joints(random_joints(rng, arms))
        step(scene, 2)
        shapes = arms.contact_shapes()
        a, b = shapes.a_world_m[SHAFT], shapes.b_world_m[SHAFT]
        axis = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
        off = np.linalg.norm(np.cross(ports - b, axis), axis=1)
        assert off.max() < 1e-6  # 0.24 m of lever at float32 orientation


def test_ports_mirror_and_look_at_the_field(arms):
    left, right = arms.T_world_rcm
    np.testing.assert_allclose(left[:3, 3] * [-1, 1, 1], right[:3, 3], atol=1e-15)
    for T in (left, right):
        distance = np.linalg.norm(T[:3, 3])
        np.testing.assert_allclose(-T[:3, 2] * distance, -T[:3, 3], atol=1e-15)
        assert T[:3, 1] @ UP < -0.9  # so that at roll 0 the pivot axis is upright,
        assert T[:3, 0] @ RIGHT < -0.8  # and the jaws close from side to side


def test_positive_jaw_opens_each_finger_to_its_own_side(arms):
    arms.set_joints(home(jaw=0.6))
    shapes, T = arms.contact_shapes(), arms.T_world_tool()
    for fingers, side in ((FINGER_PLUS, 1), (FINGER_MINUS, -1)):
        along = shapes.b_world_m[fingers] - shapes.a_world_m[fingers]
        across = np.einsum("ni,ni->n", along, T[:, :3, 1])
        sine = across / np.linalg.norm(along, axis=1)
        np.testing.assert_allclose(sine, side * np.sin(0.3), atol=1e-6)


def test_closed_finger_faces_touch(arms):
    arms.set_joints(home(jaw=0.0))
    shapes = arms.contact_shapes()
    for plus, minus in ((shapes.a_world_m, shapes.a_world_m), (shapes.b_world_m, shapes.b_world_m)):
        gap = np.linalg.norm(plus[FINGER_PLUS] - minus[FINGER_MINUS], axis=1)
        thickness = shapes.radius_m[FINGER_PLUS] + shapes.radius_m[FINGER_MINUS]
        np.testing.assert_allclose(gap, thickness, atol=1e-6)
    pivot = arms.T_world_tool()[:, :3, 0]
    width = shapes.w_world_m[FINGER_PLUS]
    np.testing.assert_allclose(np.cross(width, pivot), 0.0, atol=1e-6)


def glide(arms, scene, steps):
    """Move all joints at steady rates; after twenty steps the start-up has decayed."""
    rates = np.array([0.3, -0.2, 0.02, 0.5, 0.4, -0.6, 0.5])
    for i in steps:
        command(arms, home() + rates * DT_S * i)
        scene.step()


@only_pgs
def test_measured_velocities_are_the_derivative_of_joints(arms, scene):
    glide(arms, scene, range(20))
    before = arms.joints
    glide(arms, scene, [20])
    rates = (arms.joints - before) / DT_S
    np.testing.assert_allclose(arms.joint_velocities, rates, rtol=0.02)


@only_pgs
@pytest.mark.parametrize("column", range(7))
def test_drives_reach_a_step_without_overshoot(arms, scene, column):
    start, size = home(), 0.005 if column == 2 else 0.1
    goal = start.copy()
    goal[:, column] += size
    arms.set_joints(start)
    command(arms, goal)
    progress = []
    for _ in range(24):
        scene.step()
        progress.append((arms.joints - start)[:, column] / size)
    assert np.max(progress) < 1.01
    np.testing.assert_allclose(progress[-1], 1.0, atol=1e-3)


@pytest.mark.parametrize("direction", [RIGHT, UP, AWAY], ids=["right", "up", "away"])
def test_tip_follows_40_mm_s(arms, scene, direction):
    """Give targets at every physics step; the outer three joints alone move the tip."""
    joints, speed = home(insertion=0.1), 0.040
    arms.set_joints(joints)
    start = arms.T_world_tool()[:, :3, 3]
    for i in range(1, 40):
        for arm, instrument in enumerate(arms.mounted):
            velocity_rcm_m_s = arms.T_world_rcm[arm, :3, :3].T @ direction * speed
            joints[arm, :3] += DT_S * outer_rates(joints[arm, :6], instrument, velocity_rcm_m_s)
        command(arms, joints)
        scene.step()
        wanted = start + direction * speed * DT_S * i
        assert np.linalg.norm(arms.T_world_tool()[:, :3, 3] - wanted, axis=1).max() < 0.3e-3


def outer_rates(joints, instrument, velocity_rcm_m_s):
    """Return rates of the outer three joints for a tip velocity, by central differences."""

    def tip(q):
        return forward_kinematics(q, instrument)[:3, 3]

    steps = 1e-5 * np.eye(6)[:3]
    columns = [(tip(joints + step) - tip(joints - step)) / 2e-5 for step in steps]
    return np.linalg.solve(np.column_stack(columns), velocity_rcm_m_s)


@pytest.mark.parametrize("direction", [RIGHT, UP, AWAY], ids=["right", "up", "away"])
def test_tip_deflects_less_than_a_fifth_of_a_millimetre_under_1_n(arms, scene, direction):
    arms.set_joints(home(insertion=0.1, wrist_pitch=0.4, wrist_yaw=-0.6))
    start = arms.T_world_tool()[:, :3, 3]
    deflections = []
    for _ in range(60):
        push_at_tips(arms, direction)
        scene.step()
        deflections.append(np.linalg.norm(arms.T_world_tool()[:, :3, 3] - start, axis=1))
    assert np.max(deflections) < 0.2e-3
    assert np.min(deflections[-1]) > 0.1e-6  # the wrench has an effect
    assert np.ptp(deflections[-20:], axis=0).max() < 1e-6  # no vibration is left


def push_at_tips(arms, force):
    shapes = arms.contact_shapes()
    forces, torques = np.zeros((8, 3)), np.zeros((8, 3))
    tips = arms.T_world_tool()[:, :3, 3]
    forces[FINGER_PLUS] = force
    torques[FINGER_PLUS] = np.cross(tips - shapes.T_world_link[FINGER_PLUS, :3, 3], force)
    arms.apply_wrenches(forces, torques)


@pytest.mark.parametrize(("share", "opens"), [(0.8, False), (1.2, True)])
def test_pinch_is_bounded_by_the_jaw_torque(arms, scene, share, opens):
    arms.set_joints(home(jaw=0.0))
    command(arms, home(jaw=-0.3))
    step(scene, 10)
    for _ in range(10):
        torques = np.zeros((8, 3))
        pivot = arms.T_world_tool()[:, :3, 0]
        torque = np.array([[share * instrument.jaw_torque_nm] for instrument in arms.mounted])
        torques[FINGER_PLUS], torques[FINGER_MINUS] = -pivot * torque, pivot * torque
        arms.apply_wrenches(np.zeros((8, 3)), torques)
        scene.step()
    assert (arms.joints[:, 6] > 1e-3).all() == opens


def test_fingers_do_not_cross_when_pressed_together(arms, scene):
    arms.set_joints(home(jaw=0.4))
    command(arms, home(jaw=-0.3))
    for _ in range(60):
        scene.step()
        assert arms.joints[:, 6].min() > -1e-3
    assert arms.joints[:, 6].max() < 1e-3


def test_fingers_cannot_be_forced_open_beyond_the_jaw_range(arms, scene):
    upper = np.array([instrument.jaw_range_rad[1] for instrument in arms.mounted])
    joints = home()
    joints[:, 6] = upper
    arms.set_joints(joints)
    for _ in range(30):
        pivot, torques = arms.T_world_tool()[:, :3, 0], np.zeros((8, 3))
        torques[FINGER_PLUS], torques[FINGER_MINUS] = -pivot, pivot  # 1 N m, above the drives
        arms.apply_wrenches(np.zeros((8, 3)), torques)
        scene.step()
    assert (arms.joints[:, 6] < upper + 0.01).all()


@pytest.mark.parametrize("end", [0, 1])
def test_joints_stay_within_limits(arms, scene, end):
    command(arms, np.full((2, 7), (-10.0, 10.0)[end]))
    step(scene, 240)
    for measured, instrument in zip(arms.joints, arms.mounted, strict=True):
        limits = np.vstack([joint_limits(instrument), instrument.jaw_range_rad])
        limits[6, 0] = 0.0
        np.testing.assert_allclose(measured, limits[:, end], atol=1e-3)


def wander_one(arms, scene, i):
    """Take one step under changing targets and wrenches; return joints and velocities."""
    joints = home(insertion=0.1)
    joints[:, :6] += 0.02 * np.sin(0.05 * i + np.arange(6)) * [1, 1, 0.2, 1, 1, 1]
    joints[:, 6] = 0.3 + 0.5 * np.sin(0.07 * i)
    command(arms, joints)
    force = np.zeros((8, 3))
    force[[3, 5]] = 0.3 * np.sin(i), 0.2, 0.1
    arms.apply_wrenches(force, 0.01 * force)
    scene.step()
    return np.array([arms.joints, arms.joint_velocities])


def wander(arms, scene, n):
    return np.array([wander_one(arms, scene, i) for i in range(n)])


@pytest.mark.parametrize("detour", ["none", "mount", "teleport"])
def test_a_restored_run_repeats_bit_for_bit(arms, scene, detour):
    wander(arms, scene, 50)
    saved = arms.state()
    first = wander(arms, scene, 240)
    if detour == "mount":
        arms.mount("scissors")
        step(scene, 20)
    elif detour == "teleport":
        arms.set_joints(home(yaw=0.5))
        step(scene, 20)
    arms.restore(saved)
    again = wander(arms, scene, 240)
    np.testing.assert_array_equal(first, again)


def test_a_restored_run_continues_to_its_earlier_targets(arms, scene):
    command(arms, home(yaw=0.2, jaw=0.8))
    step(scene, 2)
    saved = arms.state()
    step(scene, 240)
    first = arms.joints
    command(arms, home())
    step(scene, 20)
    arms.restore(saved)
    step(scene, 240)
    np.testing.assert_array_equal(arms.joints, first)


def test_a_state_can_be_restored_in_other_arms(arms, scene):
    arms.mount("scissors")
    wander(arms, scene, 20)
    saved = arms.state()
    other_scene = new_scene()
    other = Arms(other_scene, render=False)
    other.restore(saved)
    assert other.mounted[RIGHT_ARM].name == "scissors"
    np.testing.assert_array_equal(wander(arms, scene, 60), wander(other, other_scene, 60))


def test_saving_does_not_change_the_run(arms, scene):
    start = arms.state()
    plain = wander(arms, scene, 60)
    arms.restore(start)
    watched = []
    for i in range(60):
        arms.state()
        watched.append(wander_one(arms, scene, i))
    np.testing.assert_array_equal(plain, watched)


def test_mounting_keeps_joints_and_leaves_all_parked_tools_alone(arms, scene):
    arms.set_joints(home(yaw=0.1, wrist_yaw=0.3))
    before = arms.joints
    arms.mount("scissors")
    assert [tool.name for tool in arms.mounted] == ["grasper", "scissors"]
    np.testing.assert_allclose(arms.joints, before, atol=1e-7)
    parked = ~arms.state()["mounted"]
    before = arms.state()["qpos"][parked]
    assert len(before) == len(right_tools()) - 1
    wander(arms, scene, 60)
    np.testing.assert_array_equal(arms.state()["qpos"][parked], before)
    np.testing.assert_array_equal(arms.state()["qvel"][parked], 0.0)


def test_mounting_brings_joints_within_the_new_limits(arms):
    arms.mount("scissors")
    arms.set_joints(home(wrist_pitch=1.3, jaw=1.2))
    arms.mount("clip_applier")
    limit = INSTRUMENTS["clip_applier"]
    assert arms.joints[RIGHT_ARM, 4] == pytest.approx(limit.wrist_pitch_limit_rad, abs=1e-6)
    assert arms.joints[RIGHT_ARM, 6] == pytest.approx(limit.jaw_range_rad[1], abs=1e-6)


def test_only_the_right_arms_own_tools_can_be_mounted(arms):
    with pytest.raises(ValueError, match=r"'grasper'.*clip_applier.*scissors"):
        arms.mount("grasper")


def add_block(scene, name, T_world_tool, ahead_m):
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.02, 0.02, 0.005])
    block = builder.build_static(name)
    T = T_world_tool.copy()
    T[:3, 3] += ahead_m * T[:3, 2]
    block.set_pose(sapien.Pose(T))


def test_a_force_is_measured_only_when_an_arm_presses_on_the_liver(arms, scene):
    arms.set_joints(home(jaw=0.0))
    step(scene, 5)
    assert arms.contact_forces_n().on_liver_n == 0.0
    add_block(scene, LIVER, arms.T_world_tool()[0], 0.006)
    command(arms, home(insertion=HOME_JOINTS[2] + 0.0015, jaw=0.0))
    step(scene, 60)
    forces = arms.contact_forces_n()
    assert forces.on_liver_n > 0.5
    assert forces.between_arms_n == 0.0


def test_a_touch_of_the_assistant_s_grasper_is_contact_between_instruments(arms, scene):
    arms.set_joints(home(jaw=0.0))
    add_block(scene, ASSISTANT, arms.T_world_tool()[0], 0.006)
    command(arms, home(insertion=HOME_JOINTS[2] + 0.0015, jaw=0.0))
    step(scene, 60)
    forces = arms.contact_forces_n()
    assert forces.between_arms_n > 0.5
    assert forces.on_liver_n == 0.0


@only_pgs
def test_the_force_on_the_liver_grows_by_the_force_on_the_shaft(arms, scene):
    arms.set_joints(home(jaw=0.0))
    T_world_tool = arms.T_world_tool()[0]
    add_block(scene, LIVER, T_world_tool, 0.0051)
    command(arms, home(insertion=HOME_JOINTS[2] + 0.001, jaw=0.0))
    step(scene, 120)
    before = arms.contact_forces_n().on_liver_n
    force, push_n = np.zeros((8, 3)), 3.0
    force[SHAFT[0]] = push_n * T_world_tool[:3, 2]
    for _ in range(60):
        arms.apply_wrenches(force, np.zeros((8, 3)))
        scene.step()
    # the drive keeps a tenth: the solver's iterations do not quite converge
    assert arms.contact_forces_n().on_liver_n - before == pytest.approx(push_n, rel=0.15)


@only_pgs
def test_arms_at_rest_under_a_load_have_no_velocity(arms, scene):
    arms.set_joints(home())
    for _ in range(60):
        push_at_tips(arms, np.array([0.5, 0.5, 0.5]))
        scene.step()
    assert abs(arms.joint_velocities).max() < 1e-4


def test_the_arms_push_each_other(arms, scene):
    joints = np.stack([home()[0], home()[1]])
    joints[:, 2] = 0.13  # both tips at the middle of the field
    joints[:, 0] = 0.4, -0.4
    arms.set_joints(joints)
    assert arms.contact_forces_n().between_arms_n == 0.0
    joints[:, 0] = -0.1, 0.1
    felt = []
    for fraction in np.linspace(0, 1, 120):
        towards = joints.copy()
        towards[:, 0] = np.array([0.4, -0.4]) * (1 - fraction) + joints[:, 0] * fraction
        command(arms, towards)
        scene.step()
        felt.append(arms.contact_forces_n().between_arms_n)
    assert max(felt) > 1.0


def test_wrench_is_about_the_link_origin(arms, scene):
    """Check that a force through the yaw axis turns no finger; the same force beside it does."""
    arms.set_joints(home())
    T = arms.T_world_tool()
    forces, torques = np.zeros((8, 3)), np.zeros((8, 3))
    forces[FINGER_PLUS] = T[:, :3, 1]
    arms.apply_wrenches(forces, torques)
    scene.step()
    through = abs(arms.joint_velocities[:, 6]).max()
    arms.set_joints(home())
    torques[FINGER_PLUS] = np.cross(0.02 * T[:, :3, 2], T[:, :3, 1])
    arms.apply_wrenches(forces, torques)
    scene.step()
    assert abs(arms.joint_velocities[:, 6]).min() > 20 * through


def test_tool_frames_agree_with_a_turned_port(arms):
    """Turn the outer yaw: it turns the tool about the port's y axis (the DH table's first)."""
    arms.set_joints(home())
    before = arms.T_world_tool()
    arms.set_joints(home(yaw=0.2))
    for T_port, old, new in zip(arms.T_world_rcm, before, arms.T_world_tool(), strict=True):
        turn = np.eye(4)
        turn[:3, :3] = axis_angle(np.array([0.0, -1.0, 0.0]), 0.2)
        expected = T_port @ turn @ inverse_pose(T_port) @ old
        np.testing.assert_allclose(new, expected, atol=FLOAT32_CHAIN)
