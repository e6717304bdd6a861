"""Find clips and ends of cuts in a view's maps of evidence, near their estimated places."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from controller.perception.graph import Shown
from controller.perception.network import DENSE, STRIDE
from tissue_sim.frames import Array
from tissue_sim.sensing.glance import Picture

LEAST = 0.6  # assumed: probability of a cell that counts as evidence
WINDOW_M, LEAST_PX = 0.003, 6.0  # radius of the search around an estimated place
BEHIND_M = 0.005  # nearer to the eye, or behind it, nothing is found


def find(
    what: str, shown: Shown, picture: Picture, place: Array, others: Sequence[Array] = ()
) -> Array | None:
    """Return the pixel (2,) of evidence in a picture near a place (3,), if there is evidence.

    `what` is one of `network.DENSE`. Evidence nearer to the others of its kind belongs to them.
    """
    (pixel,), (ahead,) = picture.project(place[None])
    if ahead < BEHIND_M:
        return None
    window_px = max(WINDOW_M * picture.focal_px / ahead, LEAST_PX)
    chance = 1.0 / (1.0 + np.exp(-shown.dense[DENSE.index(what)]))
    h, w = chance.shape
    column, row = np.meshgrid(STRIDE * (np.arange(w) + 0.5), STRIDE * (np.arange(h) + 0.5))
    away = np.hypot(column - pixel[0], row - pixel[1]) / window_px
    for other in others:
        (at,), _ = picture.project(other[None])
        theirs = np.hypot(column - at[0], row - at[1]) / window_px < away
        away = np.where(theirs, 2.0, away)
    best = np.where(away < 1.0, chance * np.exp(-(away**2)), 0.0).argmax()
    if chance.flat[best] < LEAST or away.flat[best] >= 1.0:
        return None
    beside = np.hypot(column - column.flat[best], row - row.flat[best]) < 1.5 * STRIDE
    near = np.where(beside, chance, 0.0)
    told = np.stack([column, row]) + shown.offset[DENSE.index(what)]
    return (near * told).sum((1, 2)) / near.sum()


def in_frame(picture: Picture, place: Array) -> bool:
    """Return whether a picture's frame contains a place (3,)."""
    (pixel,), (ahead,) = picture.project(place[None])
    height, width = picture.rgb.shape[:2]
    return bool(ahead > BEHIND_M and (pixel > 0.0).all() and pixel[0] < width and pixel[1] < height)
