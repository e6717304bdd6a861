"""Define the cameras: a stereo endoscope, and one camera on each instrument's wrist.

The system can also read a camera out as a narrow crop, turned to a place. The wrists' crops turn to
the right instrument's tip, the endoscope's crop to the tubes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from tissue_sim.field import Field
from tissue_sim.frames import Array, pose, unit
from tissue_sim.sensing.glance import CAMERA_NAMES
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import PATCH_LINKS, Instrument

BASELINE_M = 0.0045  # between the endoscope's eyes
NEAR_PLANE_M, FAR_PLANE_M = 0.003, 0.6  # objects nearer or farther are not drawn
WRIST_BACK_M = 0.035  # behind the wrist's pitch axis, clear of the shaft
WRIST_ASIDE_M = 0.016  # along the wrist's pitch axis

_OPTICAL = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], float)  # left, up, away of x, y, z ahead


@dataclass(frozen=True, kw_only=True)
class CameraSpec:
    """One camera: picture size, pixels, and vertical field of view."""

    name: str
    width: int = 640
    height: int = 480
    fov_rad: float = float(np.deg2rad(65.0))

    def __post_init__(self) -> None:
        known = [*CAMERA_NAMES, *CROPS]
        if self.name not in known:
            raise ValueError(f"camera {self.name!r} is unknown: choose from {known}")
        if min(self.width, self.height) < 1 or not 0.0 < self.fov_rad < np.pi:
            raise ValueError(f"camera {self.name}: impossible size or field of view: {self}")

    @property
    def focal_px(self) -> float:
        """Return the focal length."""
        return 0.5 * self.height / float(np.tan(0.5 * self.fov_rad))


CROPS = {
    "endoscope_left_close": "endoscope_left",
    "wrist_left_tip": "wrist_left",
    "wrist_right_tip": "wrist_right",
}
CAMERAS = tuple(CameraSpec(name=name) for name in CAMERA_NAMES)


def T_world_camera(field: Field, name: str, aim_m: Array | None = None) -> Array:
    """Return a camera's current pose (4, 4): x ahead, y left, z up.

    A crop is turned to the right tip, or to a point `aim_m` (3,) of the world.
    """
    if name in CROPS:
        tip = field.arms.T_world_tool()[RIGHT_ARM, :3, 3]
        return _turned(T_world_camera(field, CROPS[name]), tip if aim_m is None else aim_m)
    if name == "endoscope_left":
        return looking(field.T_world_endoscope)
    if name == "endoscope_right":
        return looking(field.T_world_endoscope @ pose(np.eye(3), np.array([-BASELINE_M, 0, 0])))
    arm = LEFT_ARM if name == "wrist_left" else RIGHT_ARM
    link = arm * len(PATCH_LINKS) + PATCH_LINKS.index("wrist")
    return field.arms.T_world_links()[link] @ _T_wrist_camera(field.arms.mounted[arm])


def looking(T_world_eye: Array) -> Array:
    """Return the renderer's pose (x ahead) of an eye with +x left, +y up, +z away."""
    return pose(T_world_eye[:3, :3] @ _OPTICAL, T_world_eye[:3, 3])


def _turned(T_world_eye: Array, target: Array) -> Array:
    """Return the pose of the same eye, turned to face a point (3,)."""
    ahead = unit(target - T_world_eye[:3, 3])
    left = unit(np.cross(T_world_eye[:3, 2], ahead))
    axes = np.stack([ahead, left, np.cross(ahead, left)], axis=1)
    return pose(axes, T_world_eye[:3, 3])


@cache
def _T_wrist_camera(tool: Instrument) -> Array:
    """Return the camera's pose in the wrist's frame: x along the clevis, z along the pitch axis."""
    tip = np.array([tool.pitch_to_yaw_m + tool.yaw_to_tip_m, 0.0, 0.0])
    eye = np.array([-WRIST_BACK_M, 0.0, WRIST_ASIDE_M])
    ahead = unit(tip - eye)
    left = unit(np.cross([0.0, 0.0, 1.0], ahead))
    return pose(np.stack([ahead, left, np.cross(ahead, left)], axis=1), eye)
