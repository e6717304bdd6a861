"""Hands without a safety filter: they put tools anywhere, close them, and draw them straight on."""

from __future__ import annotations

import numpy as np

from controller.kinematics import inverse_kinematics
from tissue_sim.frames import AWAY, Array, inverse_pose, pose, unit
from tissue_sim.tools.arms import RIGHT_ARM, JointCommand
from tissue_sim.world import World


def put(world: World, arm: int, T_world_tool: Array, jaw_rad: float) -> None:
    """Put a tool at a pose, at rest and on its target, without a way there."""
    joints = world.target
    joints[arm] = _joints_at(world, arm, T_world_tool, jaw_rad)
    world.arms.set_joints(joints)
    world.restore(world.state() | {"target": joints})
    world.step(JointCommand(joints=joints))


def move(world: World, arm: int, by_m: Array, *, speed_m_s: float) -> None:
    """Draw a tool straight on, at a steady speed, from where it was told to be."""
    T, jaw_rad = world.arms.T_world_tool()[arm], float(world.target[arm, 6])
    n = max(round(float(np.linalg.norm(by_m)) / speed_m_s / world.config.control_step_s), 1)
    for share in np.linspace(0.0, 1.0, n + 1)[1:]:
        there = T.copy()
        there[:3, 3] += share * by_m
        joints = world.target
        joints[arm] = _joints_at(world, arm, there, jaw_rad)
        world.step(JointCommand(joints=joints))


def close(
    world: World, arm: int, jaw_rad: float, *, steps: int = 12, intended: str | None = None
) -> None:
    """Turn a tool's jaws to an angle; below 0 they press."""
    joints = world.target
    for angle in np.linspace(joints[arm, 6], jaw_rad, steps + 1)[1:]:
        joints[arm, 6] = angle
        world.step(JointCommand(joints=joints), intended=intended)


def wait(world: World, steps: int) -> None:
    """Hold still."""
    for _ in range(steps):
        world.step(JointCommand(joints=world.target))


def poke(world: World, tool: str, ring: int, depth_m: float) -> None:
    """Drive a closed tool straight at the gallbladder, so far beyond its surface."""
    world.equip(tool)
    T = before_sac(world, ring, -0.008)
    put(world, RIGHT_ARM, T, 0.0)
    move(world, RIGHT_ARM, (0.008 + depth_m) * T[:3, 2], speed_m_s=0.1)


def before_sac(world: World, ring: int, beyond_m: float) -> Array:
    """Return `T_world_tool` of a tool that points at the gallbladder's front, this far beyond."""
    rings, x = world.organ.sac_rings, world.tissue.positions().astype(float)
    outer = x[rings[ring - 1 : ring + 1, 11:]].reshape(-1, 3)
    front = outer[np.argmin(outer @ AWAY)]
    along = unit(x[rings[ring + 1, 0]] - x[rings[ring - 1, 0]])
    z = unit(AWAY - (AWAY @ along) * along)
    return pose(np.stack([along, np.cross(z, along), z], axis=1), front + beyond_m * z)


def _joints_at(world: World, arm: int, T_world_tool: Array, jaw_rad: float) -> Array:
    T_rcm = inverse_pose(world.arms.T_world_rcm[arm]) @ T_world_tool
    near = world.arms.joints[arm, :6]
    return np.append(inverse_kinematics(T_rcm, world.arms.mounted[arm], near), jaw_rad)
