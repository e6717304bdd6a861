"""Define the input of a robot with cameras in one control step: pictures, encoders, currents.

The input contains nothing of the tissue except the pictures. `eyes.py` reads it from the world;
perception converts it to an `Observation`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Encoded

CAMERA_NAMES = ("endoscope_left", "endoscope_right", "wrist_left", "wrist_right")


@dataclass(frozen=True, kw_only=True)
class Picture:
    """The picture of one camera.

    Attributes:
        rgb: (height, width, 3) uint8.
        T_endoscope_camera: (4, 4) pose of the camera according to the encoders. Axes are x ahead, y
            left, z up.
        focal_px: Focal length; the optical axis passes through the middle of the picture.
    """

    rgb: NDArray[np.uint8]
    T_endoscope_camera: Array
    focal_px: float

    def project(self, points: Array) -> tuple[Array, Array]:
        """Return pixels (n, 2), column and row, and distances ahead (n,) of points (n, 3).

        Points are in the endoscope's frame. Points beside or behind the camera, with a distance
        ahead below a millimetre, have no meaningful pixel.
        """
        R, t = self.T_endoscope_camera[:3, :3], self.T_endoscope_camera[:3, 3]
        height, width = self.rgb.shape[:2]
        return pixels_of((points - t) @ R, self.focal_px, width, height)


def pixels_of(
    points_camera: Array, focal_px: float, width: int, height: int
) -> tuple[Array, Array]:
    """Return pixels (n, 2), column and row, and distances ahead (n,) of points (n, 3).

    The points are in the camera's frame: x ahead, y left, z up. A point less than a millimetre
    ahead has no meaningful pixel.
    """
    ahead, left, up = points_camera.T
    scale = focal_px / np.maximum(ahead, 1e-3)
    return np.stack([0.5 * width - scale * left, 0.5 * height - scale * up], axis=1), ahead


@dataclass(frozen=True, kw_only=True)
class Glance(Encoded):
    """One control step.

    Attributes:
        pictures: Pictures by view; empty in most steps.
    """

    pictures: dict[str, Picture] = field(default_factory=dict)
