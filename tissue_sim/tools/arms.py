"""Simulate both patient-side manipulators in SAPIEN: drives, contact, tool exchange, state.

The left arm (row 0) is PSM2 with the grasper. The right arm (row 1) is PSM1 with a clip applier or
the scissors. All tools of the right arm always exist; the unmounted tools are parked out of reach,
all in one place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sapien
from numpy.typing import NDArray

from tissue_sim.frames import UP, Array, field_point, pose, unit
from tissue_sim.read_only import seal
from tissue_sim.tools.drives import drives, set_drive
from tissue_sim.tools.instruments import (
    CLIP_APPLIER,
    GRASPER,
    INSTRUMENTS,
    PATCH_LINKS,
    Instrument,
    link_patches,
    right_tools,
)
from tissue_sim.tools.psm import T_yaw_tool, joint_limits
from tissue_sim.tools.urdf import JOINT_ORDER, urdf_path

Numbers = NDArray[np.floating]  # the simulator uses float32

LEFT_ARM, RIGHT_ARM = 0, 1
# names in contacts: links are "psm1:shaft"...
PSM2, PSM1, LIVER, ASSISTANT = "psm2", "psm1", "liver", "assistant"

# Assumed: each port aside of the field's centre, above it and nearer to the surgeon.
PORT_RIGHT_M = 0.065
PORT_UP_M = 0.035
PORT_AWAY_M = -0.110
PARKED_FROM_PORT_M = np.array([0.0, -1.0, 0.0])  # behind the surgeon, out of reach
HOME_JOINTS = np.array([0.0, 0.0, 0.08, 0.0, 0.0, 0.0, 0.35])  # assumed: before the tissue, ajar

SOLVER_ITERATIONS = 15  # assumed
CONTACT_OFFSET_M = 0.002  # assumed: distance from which the simulator tests for contact
PARKED_SLEEP_J_KG = 1e-6  # kinetic energy over mass; any positive value works
FIRST_GROUP_BIT = 28  # one bit per arm, in collision-group word 2


@dataclass(frozen=True, kw_only=True)
class JointCommand:
    """Joint targets of both arms.

    Columns: outer yaw, outer pitch (rad), insertion (m), roll, wrist pitch, wrist yaw, jaw (rad).
    The jaw column is the total opening. A negative opening presses the fingers together, up to the
    drive's torque.
    """

    joints: Array  # (2, 7), rows left and right arm; read-only

    def __post_init__(self) -> None:
        seal(self)


@dataclass(frozen=True, kw_only=True)
class ContactShapes:
    """Eight rounded patches: shaft end, wrist, finger+, finger- of the left, then of the right arm.

    A patch is every point within `radius_m` of {a + t (b - a) + s w, t in [0, 1], s in [-1, 1]}.
    """

    a_world_m: Array  # (8, 3)
    b_world_m: Array  # (8, 3)
    w_world_m: Array  # (8, 3), zero for shaft and wrist
    radius_m: Array  # (8,)
    T_world_link: Array  # (8, 4, 4)


@dataclass(frozen=True, kw_only=True)
class ContactForces:
    """Total normal force (N) of the last step, summed over contact points.

    Attributes:
        between_arms_n: Between the arms, and of the arms with the assistant's grasper.
        on_liver_n: Of the arms on the liver.
    """

    between_arms_n: float
    on_liver_n: float


def port_pose(arm: int) -> Array:
    """Return `T_world_rcm` (4, 4) of an arm's port.

    At zero joints the shaft points at the field's centre and the jaws close from side to side.
    """
    side = 1.0 if arm == RIGHT_ARM else -1.0
    position = field_point(side * PORT_RIGHT_M, PORT_UP_M, PORT_AWAY_M)
    back = unit(position)  # from the field's centre to the port: the base's z
    down = unit(-UP + (UP @ back) * back)
    return pose(np.stack([np.cross(down, back), down, back], axis=1), position)


class _Psm:
    """One articulated arm with one instrument; joints are (7,), with one column for the jaw."""

    def __init__(
        self, scene: sapien.Scene, instrument: Instrument, name: str, arm: int, *, render: bool
    ) -> None:
        self.instrument = instrument
        self.articulation = _load(scene, instrument, render=render)
        self._joints = [self.articulation.find_joint_by_name(name) for name in JOINT_ORDER]
        links = {link.name: link for link in self.articulation.links}
        for link in links.values():
            link.entity.name = f"{name}:{link.name}"
            _disable_gravity_and_self_collision(link, arm)
        for joint, drive in zip(self._joints, drives(instrument), strict=True):
            set_drive(joint, drive)
        self._palm = links["palm"]
        self.patch_links = [links[name] for name in PATCH_LINKS]
        patches = link_patches(instrument)
        self.patch_points = np.stack([patches.a_link_m, patches.b_link_m, patches.w_link_m], axis=1)
        self.patch_radius_m = patches.radius_m
        self._T_palm_tool = T_yaw_tool(instrument)
        self.limits = np.vstack([joint_limits(instrument), instrument.jaw_range_rad])
        self.drive_targets = np.zeros(8)

    def place(self, T_world_rcm: Array, *, in_use: bool) -> None:
        """Move the whole arm, with its remote centre to a pose.

        An arm that is not in use stands still, exactly, and the simulator may skip it.
        """
        self.articulation.set_root_pose(sapien.Pose(T_world_rcm))
        self.articulation.set_sleep_threshold(0.0 if in_use else PARKED_SLEEP_J_KG)

    def set_drive_targets(self, targets: Array) -> None:
        """Set targets (8,) of the simulator's joints, in `JOINT_ORDER`."""
        self.drive_targets = targets
        for joint, target in zip(self._joints, targets.tolist(), strict=True):
            joint.set_drive_target(target)

    def set_joints(self, joints: Array) -> None:
        limited = self.limited(joints)
        limited[6] = max(limited[6], 0.0)
        split = _split_jaw(limited)
        self.set_drive_targets(split)
        self.write(split, np.zeros(8))

    def write(self, qpos: Numbers, qvel: Numbers) -> None:
        """Set the simulator's joint positions and velocities (8,) at once."""
        self.articulation.set_qpos(qpos)
        self.articulation.set_qvel(qvel)

    def joints(self) -> Array:
        return _sum_jaw(self.articulation.get_qpos())

    def joint_velocities(self) -> Array:
        return _sum_jaw(self.articulation.get_qvel())

    def targets(self) -> Array:
        return _sum_jaw(self.drive_targets)

    def T_world_tool(self) -> Array:
        return self._palm.entity_pose.to_transformation_matrix() @ self._T_palm_tool

    def limited(self, joints: Array) -> Array:
        return np.clip(joints, self.limits[:, 0], self.limits[:, 1])


def _load(
    scene: sapien.Scene, instrument: Instrument, *, render: bool
) -> sapien.physx.PhysxArticulation:
    loader = scene.create_urdf_loader()
    loader.fix_root_link = True
    articulation = loader.load(str(urdf_path(instrument, visuals=render)))
    articulation.set_solver_position_iterations(SOLVER_ITERATIONS)
    return articulation


def _disable_gravity_and_self_collision(
    link: sapien.physx.PhysxArticulationLinkComponent, arm: int
) -> None:
    link.disable_gravity = True
    link.set_linear_damping(0.0)
    link.set_angular_damping(0.0)
    for shape in link.collision_shapes:
        shape.contact_offset = CONTACT_OFFSET_M
        groups = shape.get_collision_groups()
        groups[2] |= 1 << (FIRST_GROUP_BIT + arm)  # shapes that share a bit never collide
        shape.set_collision_groups(groups)


def _split_jaw(joints: Array) -> Array:
    """Convert (7,) with the total jaw angle to (8,) with one angle per finger."""
    split = np.empty(8)
    split[:6], split[6:] = joints[:6], 0.5 * joints[6]
    return split


def _sum_jaw(joints: Numbers) -> Array:
    """Convert (8,) with one angle per finger to (7,) with the total jaw angle."""
    summed = np.empty(7)
    summed[:6], summed[6] = joints[:6], joints[6] + joints[7]
    return summed


def _normal_force_n(contact: sapien.physx.PhysxContact, dt_s: float) -> float:
    return sum(abs(float(np.dot(point.impulse, point.normal))) for point in contact.points) / dt_s


class Arms:
    """Two arms that follow joint targets, react to wrenches, and can be saved and restored whole.

    Make the scene with `enable_tgs = False` in the simulator's scene configuration. The TGS
    solver's velocities are those of its last substep, less than half of the true ones. With this
    solver, a link under a constant wrench seems to move.
    """

    def __init__(self, scene: sapien.Scene, *, render: bool) -> None:
        self._scene = scene
        self.T_world_rcm = np.stack([port_pose(LEFT_ARM), port_pose(RIGHT_ARM)])
        self._left = _Psm(scene, INSTRUMENTS[GRASPER], PSM2, LEFT_ARM, render=render)
        self._right = {
            name: _Psm(scene, INSTRUMENTS[name], PSM1, RIGHT_ARM, render=render)
            for name in right_tools()
        }
        self._left.place(self.T_world_rcm[LEFT_ARM], in_use=True)
        for psm in self._right.values():
            self._park(psm)
        self._mounted: tuple[_Psm, _Psm]
        self._select(CLIP_APPLIER)
        self.set_joints(np.tile(HOME_JOINTS, (2, 1)))

    @property
    def mounted(self) -> tuple[Instrument, Instrument]:
        """Return the instruments on the left and right arm."""
        return self._mounted[0].instrument, self._mounted[1].instrument

    def mount(self, instrument_name: str) -> None:
        """Mount another tool on the right arm, at rest at the same joints and targets.

        Values beyond the new tool's limits are clipped to the limit.

        Raises:
            ValueError: the right arm has no such tool.
        """
        if instrument_name not in self._right:
            raise ValueError(
                f"no {instrument_name!r} for the right arm; choose from {sorted(self._right)}"
            )
        old = self._mounted[RIGHT_ARM]
        if old.instrument.name == instrument_name:
            return
        joints, targets = old.joints(), old.targets()
        self._park(old)
        self._select(instrument_name)
        self._mounted[RIGHT_ARM].set_joints(joints)
        right = self._mounted[RIGHT_ARM]
        right.set_drive_targets(_split_jaw(right.limited(targets)))

    def limited(self, joints: Array) -> Array:
        """Clip joints (2, 7) to the mounted instruments' limits."""
        return np.clip(joints, self.limits[..., 0], self.limits[..., 1])

    def drive(self, joints: Array) -> None:
        """Set drive targets (2, 7) within the limits, during a control step."""
        for psm, row in zip(self._mounted, joints, strict=True):
            psm.set_drive_targets(_split_jaw(row))

    def set_joints(self, joints: Array) -> None:
        """Set both arms to joints (2, 7) at once, at rest, with the same drive targets."""
        for psm, row in zip(self._mounted, joints, strict=True):
            psm.set_joints(row)

    @property
    def joints(self) -> Array:
        """Return the (2, 7) measured joints; the jaw is the sum of both finger angles."""
        return np.array([psm.joints() for psm in self._mounted])

    @property
    def joint_velocities(self) -> Array:
        """Return the (2, 7) measured joint velocities (rad/s, m/s)."""
        return np.array([psm.joint_velocities() for psm in self._mounted])

    def T_world_tool(self) -> Array:
        """Return the (2, 4, 4) tool frames, from the simulator's links."""
        return np.array([psm.T_world_tool() for psm in self._mounted])

    def T_world_links(self) -> Array:
        """Return the (8, 4, 4) poses of both arms' links that tissue can touch."""
        poses = [link.entity_pose for link in self._patch_links]
        return np.array([pose.to_transformation_matrix() for pose in poses], float)

    def contact_shapes(self) -> ContactShapes:
        """Return the surfaces of both arms that tissue can touch, at their current poses."""
        T = self.T_world_links()
        world = self._patch_points @ T[:, :3, :3].transpose(0, 2, 1)  # (8, abw, 3)
        world[:, :2] += T[:, None, :3, 3]
        return ContactShapes(
            a_world_m=world[:, 0],
            b_world_m=world[:, 1],
            w_world_m=world[:, 2],
            radius_m=self._patch_radius_m,
            T_world_link=T,
        )

    def apply_wrenches(self, force_world_n: Numbers, torque_world_nm: Numbers) -> None:
        """Add forces (8, 3) and torques (8, 3) about the patches' link origins, for one step."""
        wrenches = zip(force_world_n.tolist(), torque_world_nm.tolist(), strict=True)
        for link, (force, torque) in zip(self._patch_links, wrenches, strict=True):
            if any(force) or any(torque):
                link.add_force_torque(force, torque)

    def contact_forces_n(self) -> ContactForces:
        """Return the rigid contact of the last step: between instruments, and with `LIVER`."""
        between = liver = 0.0
        for contact in self._scene.get_contacts():
            owners = {body.entity.name.split(":")[0] for body in contact.bodies}
            if len(owners & {PSM1, PSM2, ASSISTANT}) == 2:
                between += _normal_force_n(contact, self._scene.timestep)
            elif LIVER in owners and owners & {PSM1, PSM2}:
                liver += _normal_force_n(contact, self._scene.timestep)
        return ContactForces(between_arms_n=between, on_liver_n=liver)

    def state(self) -> dict[str, NDArray]:
        """Return all that the next step depends on; rows: left, then the right arm's tools."""
        self.settle()
        return self.snapshot()

    def snapshot(self) -> dict[str, NDArray]:
        """Return `state` without settling: good for checks, not for an exact restore."""
        psms = self._all
        return {
            "qpos": np.stack([psm.articulation.get_qpos() for psm in psms]),
            "qvel": np.stack([psm.articulation.get_qvel() for psm in psms]),
            "drive_targets": np.stack([psm.drive_targets for psm in psms]),
            "mounted": np.array([psm in self._mounted for psm in psms]),
        }

    def restore(self, state: dict[str, NDArray]) -> None:
        """Restore a value that `state` returned, bit for bit."""
        tools = list(self._right)
        name = tools[int(np.argmax(state["mounted"][1:]))]
        for psm in self._right.values():
            psm.place(self._parking_pose, in_use=False)
        self._select(name)
        rows = zip(state["qpos"], state["qvel"], state["drive_targets"], strict=True)
        for psm, (qpos, qvel, targets) in zip(self._all, rows, strict=True):
            psm.set_drive_targets(targets)
            psm.write(qpos, qvel)

    @property
    def joint_ranges(self) -> Array:
        """Return the (3, 8, 2) joint limits of each row of `state`, one angle per finger."""
        return np.stack(
            [np.stack([_split_jaw(q) for q in psm.limits.T], axis=1) for psm in self._all]
        )

    def settle(self) -> None:
        """Make positions and velocities the simulator's only memory.

        The simulator keeps link states that differ by a rounding from the result of `set_qpos`. The
        joints are therefore written back before each control step and each save. A restored run
        then repeats bit for bit, and a save leaves the run unchanged.
        """
        for psm in self._mounted:
            psm.write(psm.articulation.get_qpos(), psm.articulation.get_qvel())

    @property
    def _all(self) -> tuple[_Psm, ...]:
        return (self._left, *self._right.values())

    @property
    def _parking_pose(self) -> Array:
        T = self.T_world_rcm[RIGHT_ARM].copy()
        T[:3, 3] += PARKED_FROM_PORT_M
        return T

    def _park(self, psm: _Psm) -> None:
        psm.place(self._parking_pose, in_use=False)
        psm.set_joints(HOME_JOINTS)

    def _select(self, instrument_name: str) -> None:
        right = self._right[instrument_name]
        right.place(self.T_world_rcm[RIGHT_ARM], in_use=True)
        self._mounted = (self._left, right)
        self.limits = np.stack([psm.limits for psm in self._mounted])  # (2, 7, lower and upper)
        self._patch_links = [*self._left.patch_links, *right.patch_links]
        self._patch_points = np.concatenate([self._left.patch_points, right.patch_points])
        self._patch_radius_m = np.concatenate([self._left.patch_radius_m, right.patch_radius_m])
