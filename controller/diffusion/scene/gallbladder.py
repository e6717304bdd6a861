"""Compute the gallbladder's observed thickness, and its distance from the upper clips' places.

From these the expert chooses the place of the grab and the grasper's opening. The expert also
chooses how much lower than usual an upper clip is closed.
"""

from __future__ import annotations

import torch
from torch import Tensor

from controller.diffusion.scene.places import UPPER, Places
from tissue_sim.sensing.observation import SAC_POINTS
from tissue_sim.sensing.tissue_features import by_patient, foot, tubes_there

HIGH = tuple(UPPER.values())  # rows of `Places`
THICK_M = 0.01
ROOM_M = 0.004  # scale of the free room beside a place: about half a jaw's width


def gallbladder_features(now: dict[str, Tensor], places: Places) -> list[Tensor]:
    """Return the radii of the infundibulum, and the room between its wall and each high place.

    Args:
        now: Parts of `Observation.vector()`, batched (B, ...).
        places: Places on each of `TUBES`.
    """
    points_m = by_patient(places.points_m[:, HIGH]).flatten(1, 2)
    free_m = wall_distance_m(now["sac_m"], now["sac_radius_m"], points_m)
    there = tubes_there(now).repeat_interleave(len(HIGH), dim=1)
    return [now["sac_radius_m"] / THICK_M, there * torch.tanh(free_m / ROOM_M)]


def wall_distance_m(axis_m: Tensor, radius_m: Tensor, points_m: Tensor) -> Tensor:
    """Return how far points (B, m, 3) lie outside a wall around an axis; negative inside.

    Args:
        axis_m: (B, 5, 3) points of the axis.
        radius_m: (B, 5) radii of the wall at these points; linear in between.
        points_m: (B, m, 3) points.
    """
    share, from_axis_m = foot(axis_m, points_m)
    at = share * (SAC_POINTS - 1)
    first = at.detach().floor().clamp(0, SAC_POINTS - 2).long()
    low_m, high_m = radius_m.gather(1, first), radius_m.gather(1, first + 1)
    return from_axis_m - (low_m + (at - first) * (high_m - low_m))
