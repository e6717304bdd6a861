"""Tests of the kinematics: ours, from the DH table, equals the simulator's, from the URDF.

The simulator stores joint origins, joint values and link poses in float32. A product of eight
unit quaternions is then up to 1e-6 rad off. The tests read positions and quaternions as the
simulator stores them, because its rotation matrices are rounded once more.
"""

import numpy as np
import pytest
import sapien
from scipy.spatial.transform import Rotation

from tests.controller.link_poses import link_poses
from tests.joints import within_limits
from tissue_sim.frames import pose
from tissue_sim.tools.instruments import INSTRUMENTS, PATCH_LINKS
from tissue_sim.tools.psm import T_yaw_tool, forward_kinematics
from tissue_sim.tools.urdf import FINGER_SIDES, JOINT_ORDER, LINK_OF_JOINT, urdf_path

LINKS = ("base", *LINK_OF_JOINT.values(), *FINGER_SIDES)
PALM, PATCHES = LINKS.index("palm"), [LINKS.index(name) for name in PATCH_LINKS]


class Engine:
    """Gives link poses after a teleport, as the physics of the world sees them."""

    def __init__(self, articulation):
        self.articulation = articulation

    def link_poses(self, qpos):
        self.articulation.set_qpos(qpos)
        return [link.entity_pose for link in self.articulation.links]


class Model:
    """Computes link poses in float64 (Pinocchio) from the engine's joint origins in float32."""

    def __init__(self, articulation):
        self.model = articulation.create_pinocchio_model()
        self.rows = range(len(articulation.links))

    def link_poses(self, qpos):
        self.model.compute_forward_kinematics(qpos.astype(float))
        return [self.model.get_link_pose(row) for row in self.rows]


@pytest.fixture(scope="module", params=INSTRUMENTS.values(), ids=INSTRUMENTS)
def arm(request):
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    loader = scene.create_urdf_loader()
    loader.fix_root_link = True
    articulation = loader.load(str(urdf_path(request.param, visuals=False)))
    assert tuple(joint.name for joint in articulation.active_joints) == JOINT_ORDER
    assert tuple(link.name for link in articulation.links) == LINKS
    yield request.param, articulation
    scene.clear()


def drawn_qpos(instrument, n):
    """Return joints (n, 8) in the simulator's float32, so that both sides get the same numbers."""
    rng = np.random.default_rng(0)
    joints = within_limits(rng.uniform(size=(n, 6)), instrument)
    finger = rng.uniform(0.0, instrument.jaw_range_rad[1] / 2, (n, 1))
    return np.hstack([joints, finger, finger]).astype(np.float32)


def rigid(simulator_pose):
    rotation = Rotation.from_quat(simulator_pose.q.astype(float), scalar_first=True)
    return pose(rotation.as_matrix(), simulator_pose.p)


def off(T, other):
    """Return the largest distance (m) and the largest angle (rad) between poses (..., 4, 4)."""
    turn = T[..., :3, :3] @ np.swapaxes(other[..., :3, :3], -1, -2)
    angle = Rotation.from_matrix(turn.reshape(-1, 3, 3)).magnitude()
    return np.linalg.norm(T[..., :3, 3] - other[..., :3, 3], axis=-1).max(), angle.max()


@pytest.mark.parametrize("reading", [Engine, Model])
def test_a_thousand_poses_agree_to_a_micrometre_and_a_microradian(arm, reading):
    instrument, articulation = arm
    simulator, T_palm_tool = reading(articulation), T_yaw_tool(instrument)
    links, tools = [], []
    for qpos in drawn_qpos(instrument, 1000):
        joints = np.array([*qpos[:6], qpos[6] + qpos[7]], float)
        T = np.array([rigid(link) for link in simulator.link_poses(qpos)])
        links.append((T[PATCHES], list(link_poses(joints, instrument).values())))
        tools.append((T[PALM] @ T_palm_tool, forward_kinematics(joints[:6], instrument)))
    for pairs in (links, tools):
        distance, angle = off(*np.array(pairs).swapaxes(0, 1))
        assert distance <= 1e-6
        assert angle <= 1e-6
