"""Two views of a grid of points, and what an ideal network says of them."""

import numpy as np

from controller.perception.graph import Shown
from controller.perception.network import FLAGS
from controller.perception.prior import Prior
from tissue_sim.frames import Array, pose, unit
from tissue_sim.sensing.glance import Picture
from tissue_sim.sensing.observation import N_LINE

SIGMA_PX = 0.5


def prior(spread_m: float = 0.01) -> Prior:
    """Return a prior about a grid of points 100 mm ahead of the endoscope."""
    points = np.zeros((N_LINE, 3))
    points[:, 0] = np.linspace(-0.02, 0.02, N_LINE)
    points[:, 2] = 0.1
    n = 3 * N_LINE
    return Prior(
        mean=points.ravel(),
        spread=spread_m**2 * np.eye(n),
        drift=0.001**2 * np.eye(n),
        radius_m=np.full(3, 0.002),
        sac_radius_m=np.full(5, 0.01),
    )


def picture(eye: Array, focal_px: float) -> Picture:
    """Return a view from a place (3,) towards the middle of the points."""
    ahead = unit(np.array([0.0, 0.0, 0.1]) - eye)
    left = unit(np.cross([0.0, 1.0, 0.0], ahead))
    axes = np.stack([ahead, left, np.cross(ahead, left)], axis=1)
    rgb = np.zeros((400, 400, 3), np.uint8)
    return Picture(rgb=rgb, T_endoscope_camera=pose(axes, eye), focal_px=focal_px)


def shown(view: Picture, points: Array, rng: np.random.Generator) -> Shown:
    """Return what an ideal network says of points (n, 3), with some noise."""
    pixels, _ = view.project(points)
    return Shown(
        pixels=pixels + SIGMA_PX * rng.standard_normal(pixels.shape),
        log_sigma=np.full(N_LINE, np.log(SIGMA_PX / 0.8)),
        inside=np.full(N_LINE, 5.0),
        visible=np.full(N_LINE, 5.0),
        log_radius=np.zeros(N_LINE),
        dense=np.zeros((2, 100, 100)),
        offset=np.zeros((2, 2, 1, 1)),
        flags=np.zeros(len(FLAGS)),
    )


EYES = {
    "ahead": picture(np.zeros(3), 300.0),
    "beside": picture(np.array([0.06, 0.01, 0.08]), 300.0),
}
