"""Write the URDF of a PSM with one instrument from the DH table, so that both agree exactly.

The origin of each joint is its DH transform at zero, and the joint's axis is z. A turn about z and
a slide along z commute, so origin times joint motion is the DH transform. Every centre of mass lies
at its link's origin, so the simulator's link velocities and wrenches refer to the link frame.
"""

from __future__ import annotations

from functools import cache
from math import atan2, hypot
from pathlib import Path

import numpy as np

from tissue_sim.cached_files import cached_folder
from tissue_sim.frames import Array, pose
from tissue_sim.tools.instruments import SHAFT_LENGTH_M, SHAFT_RADIUS_M, WRIST_RADIUS_M, Instrument
from tissue_sim.tools.psm import T_YAW_TOOL_AXES, DhRow, dh_table, dh_transform

LINK_OF_JOINT = {
    "outer_yaw": "outer_yaw",
    "outer_pitch": "outer_pitch",
    "insertion": "carriage",
    "roll": "shaft",
    "wrist_pitch": "wrist",
    "wrist_yaw": "palm",
}
FINGER_SIDES = {"finger_plus": -1, "finger_minus": 1}  # sign of opening about x_tool
JOINT_ORDER = (*LINK_OF_JOINT, *FINGER_SIDES)

_INERTIAS = {  # mass (kg), moment of inertia (kg m2); assumed: light compared with the drives
    "base": (1.0, 1e-2),
    "outer_yaw": (0.10, 1e-3),
    "outer_pitch": (0.10, 1e-3),
    "carriage": (0.05, 1e-3),
    "shaft": (0.03, 1e-4),
    "wrist": (0.01, 2e-6),
    "palm": (0.01, 2e-6),
    "finger_plus": (0.005, 1e-6),
    "finger_minus": (0.005, 1e-6),
}


@cache
def urdf_path(instrument: Instrument, *, visuals: bool) -> Path:
    """Return the path of the URDF in the cache, with its meshes beside it."""
    meshes = _meshes(instrument) if visuals else {}
    files = {f"{link}.glb": content for link, content in meshes.items()}
    text = urdf(instrument, {link: f"{link}.glb" for link in meshes})
    return cached_folder(instrument.name, files | {"psm.urdf": text.encode()}) / "psm.urdf"


def urdf(instrument: Instrument, mesh_files: dict[str, str]) -> str:
    """Return the URDF text; `mesh_files` names the visual of each link that has a visual."""
    collisions = _collisions(instrument)
    links = [_link(name, collisions.get(name, ""), mesh_files.get(name)) for name in _INERTIAS]
    joints, parent = [], "base"
    for row in dh_table(instrument):
        joints.append(_dh_joint(row, parent, LINK_OF_JOINT[row.name]))
        parent = LINK_OF_JOINT[row.name]
    fingers = [_finger_joint(name, sense, instrument) for name, sense in FINGER_SIDES.items()]
    return "\n".join(['<robot name="psm">', *links, *joints, *fingers, "</robot>"])


def _meshes(instrument: Instrument) -> dict[str, bytes]:
    from tissue_sim.tools.instrument_meshes import link_meshes

    return link_meshes(instrument)


def _collisions(instrument: Instrument) -> dict[str, str]:
    half = instrument.finger_half_thickness_m
    return {
        "shaft": _collision(
            f'<capsule radius="{SHAFT_RADIUS_M}" length="{SHAFT_LENGTH_M}"/>',
            _origin(pose(np.eye(3), np.array([0.0, 0.0, -SHAFT_LENGTH_M / 2]))),
        ),
        "wrist": _collision(
            f'<capsule radius="{WRIST_RADIUS_M}" length="{instrument.pitch_to_yaw_m}"/>',
            f'<origin xyz="{instrument.pitch_to_yaw_m / 2} 0 0" rpy="0 {np.pi / 2} 0"/>',
        ),
        "finger_plus": _finger(instrument, half),
        "finger_minus": _finger(instrument, -half),
    }


def _finger(instrument: Instrument, y_m: float) -> str:
    """Return a finger's collision shape: the box whose edges lie on the rounded patch.

    The patch touches tissue, and the safety filter keeps its distance from the patch. A box around
    the patch would touch 0.4 half thicknesses earlier. Capsules along the edges would match
    closely. But with several shapes the order of contacts depends on the history, so a restored
    state would not continue bit for bit.
    """
    rounded_m = np.sqrt(0.5) * instrument.finger_half_thickness_m
    width_m = 2 * (instrument.finger_half_width_m + rounded_m)
    length_m = instrument.yaw_to_tip_m
    return _collision(
        f'<box size="{width_m} {2 * rounded_m} {length_m}"/>',
        f'<origin xyz="0 {y_m} {length_m / 2}" rpy="0 0 0"/>',
    )


def _collision(geometry: str, origin: str) -> str:
    return f"<collision>{origin}<geometry>{geometry}</geometry></collision>"


def _link(name: str, collision: str, mesh_file: str | None) -> str:
    mass, inertia = _INERTIAS[name]
    visual = f'<visual><geometry><mesh filename="{mesh_file}"/></geometry></visual>'
    return (
        f'<link name="{name}"><inertial><mass value="{mass}"/><inertia ixx="{inertia}"'
        f' iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial>'
        f"{visual if mesh_file else ''}{collision}</link>"
    )


def _dh_joint(row: DhRow, parent: str, child: str) -> str:
    kind = "prismatic" if row.prismatic else "revolute"
    origin = _origin(dh_transform(row))
    return _joint(row.name, kind, parent, child, origin, "0 0 1", (row.lower, row.upper))


def _finger_joint(name: str, sense: int, instrument: Instrument) -> str:
    upper = instrument.jaw_range_rad[1] / 2
    origin = _origin(T_YAW_TOOL_AXES)
    return _joint(name, "revolute", "palm", name, origin, f"{sense} 0 0", (0.0, upper))


def _joint(
    name: str,
    kind: str,
    parent: str,
    child: str,
    origin: str,
    axis: str,
    limits: tuple[float, float],
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'{origin}<axis xyz="{axis}"/><limit lower="{limits[0]}" upper="{limits[1]}"'
        ' effort="1000" velocity="100"/></joint>'
    )


def _origin(T: Array) -> str:
    """Return the URDF origin of a pose: fixed-axis roll, pitch, yaw.

    Roll is 0 where pitch is +-90 deg.
    """
    R = T[:3, :3]
    cos_pitch = hypot(R[0, 0], R[1, 0])
    pitch = atan2(-R[2, 0], cos_pitch)
    if cos_pitch > 1e-9:
        roll, yaw = atan2(R[2, 1], R[2, 2]), atan2(R[1, 0], R[0, 0])
    else:
        roll, yaw = 0.0, atan2(-R[0, 1], R[1, 1])
    x, y, z = T[:3, 3]
    return f'<origin xyz="{x} {y} {z}" rpy="{roll} {pitch} {yaw}"/>'
