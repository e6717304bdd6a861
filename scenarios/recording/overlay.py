"""Draw the observation on the endoscope's picture: points, their ellipses, hidden points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from tissue_sim.frames import Array
from tissue_sim.sensing.cameras import CAMERAS
from tissue_sim.sensing.observation import LINE_ROWS, N_LINE, Observation

SEEN, HIDDEN, CLIP = (70, 210, 255), (255, 150, 40), (255, 255, 90)
ELLIPSE_95 = 2.448  # standard deviations within which 95 % lie in a picture
LEAST_PX = 2.0


def overlaid(picture: NDArray[np.uint8], observation: Observation) -> NDArray[np.uint8]:
    """Return the picture (height, width, 3) of the left eye with the observation drawn on it."""
    image = Image.fromarray(picture)
    draw = ImageDraw.Draw(image)
    pixels, radii = projected(observation, *picture.shape[:2])
    there = observation.there
    for rows in LINE_ROWS.values():
        if there[rows].all():
            draw.line([tuple(p) for p in pixels[rows].tolist()], fill=SEEN, width=1)
    for k in np.flatnonzero(there).tolist():
        (u, v), r = pixels[k].tolist(), float(radii[k])
        colour = HIDDEN if observation.hidden[k] else CLIP if k >= N_LINE else SEEN
        draw.ellipse((u - r, v - r, u + r, v + r), outline=colour)
    return np.asarray(image)


def projected(observation: Observation, height: int, width: int) -> tuple[Array, Array]:
    """Return the points' places (n, 2), right and down, and radii (n,), in pixels.

    The camera is a pinhole (Hartley and Zisserman, Multiple View Geometry, 2004, chapter 6).
    """
    points, focal = observation.points_m(), 0.5 * height / np.tan(0.5 * CAMERAS[0].fov_rad)
    depth_m = np.maximum(points[:, 2], 1e-3)
    across = focal * points[:, :2] / depth_m[:, None]
    pixels = np.array([0.5 * width, 0.5 * height]) - across
    radii = np.maximum(ELLIPSE_95 * observation.std_m * focal / depth_m, LEAST_PX)
    return pixels, radii
