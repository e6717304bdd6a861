"""Compute a network's features of the observed tissue: relative to each tool, and along tubes."""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor

from tissue_sim.patient.tube_names import TUBES, USUAL_TUBES
from tissue_sim.sensing.observation import LIKELY, MAX_CLIPS, ROWS, TUBE_POINTS
from tissue_sim.thresholds import GRASP_MIN_TRACTION_N, HELD_PINCH_N, SPREAD_MIN_M, TAUT_MIN
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

FAR_SCALE_M, NEAR_SCALE_M = 0.03, 0.006  # a working distance; about half a jaw's length
LENGTH_M = 0.01
UNSURE_M, RADIUS_M = 0.001, 0.002
N_SEEN = ROWS["sac_m"].stop  # points of tubes and sac
WAVES_M = 0.008, 0.004, 0.002  # resolve differences of a tenth of a millimetre
FORCE_N, TOUCH_N = 2.0, 0.2
CLIPS_A_TUBE = 4  # one clip more than a tube should have
SITS_WITHIN_M = 0.003  # of the centreline; the tubes are 4 to 8 mm apart or more, assumed
SLACK = 0.02  # scale of the difference of a tube's chord over its length to `TAUT_MIN`
TRACTION_N, PINCH_N = 0.1, 0.3  # scales of a grasp's lack of traction, and of pinch
GAP_M = 0.002  # scale of the gap's difference to `SPREAD_MIN_M`


class Sitting(NamedTuple):
    """The clips on a tube, in their order along it.

    Attributes:
        places_m: (B, `CLIPS_A_TUBE`, 3) places of the first clips.
        stations_m: (B, `CLIPS_A_TUBE`) stations from the tube's fixed end, at rest.
        there: (B, `CLIPS_A_TUBE`) 1 for a clip; 0 where the other values mean nothing.
    """

    places_m: Tensor
    stations_m: Tensor
    there: Tensor


class Foot(NamedTuple):
    """The places on a tube that are nearest to points.

    Attributes:
        share: (B, m) share of the tube's length at rest, 0 to 1; the tube's points are evenly
            spaced at rest.
        distance_m: (B, m) distance from the tube's centreline.
    """

    share: Tensor
    distance_m: Tensor


def tissue_features(now: dict[str, Tensor]) -> list[Tensor]:
    """Return points relative to each tool, and the right tip's place along each tube.

    Args:
        now: parts of `Observation.vector()`, batched (B, ...).

    Returns:
        Features (B, ...), in this order. Offsets from each tip in the endoscope's frame. The same
            offsets in the tool's frame, coarse and fine. Which clips exist. `along_tube` for all
            tubes. Standard deviations and hidden marks of the points of tubes and sac. Radii and
            lengths of the tubes.
    """
    closed, exist = closed_clips(now), tubes_there(now)
    tubes_m, length_m = now["tubes_m"].flatten(0, 1), now["rest_length_m"].reshape(-1, 1)
    sitting = clips_along(tubes_m, length_m, per_tube(now["clips_m"]), per_tube(closed))
    on_tubes_m, on_tubes = by_patient(sitting.places_m), by_patient(sitting.there)
    points = torch.cat(
        [now["tubes_m"].flatten(1, 2), now["sac_m"], now["clips_m"], on_tubes_m.flatten(1, 2)],
        dim=1,
    )
    of_clips = torch.cat([closed, on_tubes.flatten(1)], dim=1)
    of_tubes = exist.repeat_interleave(TUBE_POINTS, dim=1)
    of_sac = torch.ones_like(now["sac_m"][..., 0])
    there = torch.cat([of_tubes, of_sac, of_clips], dim=1)[..., None]
    tips = now["tips_endoscope"]
    off = (points[:, None] - tips[:, :, None, :, 3]) * there[:, None]  # (B, 2, n, 3)
    off_tool = torch.einsum("baji,banj->bani", tips[..., :3], off)
    tip_m = per_tube(tips[:, RIGHT_ARM, None, :, 3])
    return [
        off / FAR_SCALE_M, off_tool / FAR_SCALE_M, torch.tanh(off_tool / NEAR_SCALE_M), of_clips,
        exist[..., None] * by_patient(along_tube(tubes_m, length_m, sitting, tip_m)),
        torch.tanh(now["std_m"][:, :N_SEEN] / UNSURE_M), now["hidden"][:, :N_SEEN],
        now["tube_radius_m"] / RADIUS_M, now["rest_length_m"] / LENGTH_M,
        torch.tanh(now["rest_length_std_m"] / UNSURE_M),
    ]  # fmt: skip


def per_tube(part: Tensor) -> Tensor:
    """Return a part (B, ...) once for each tube, (B * 3, ...): tubes are the finer of the two."""
    return part[:, None].expand(-1, len(TUBES), *part.shape[1:]).flatten(0, 1)


def by_patient(part: Tensor) -> Tensor:
    """Return a part (B * 3, ...) of all tubes as (B, 3, ...)."""
    return part.unflatten(0, (-1, len(TUBES)))


def grasp_features(now: dict[str, Tensor]) -> list[Tensor]:
    """Return (B, n) distances of the grasp from the judge's thresholds.

    The features are the tubes' straightness, the gap between tubes, the traction and the pinch.
    Each feature is zero exactly at the threshold.
    """
    chord_m = (now["tubes_m"][:, :, -1] - now["tubes_m"][:, :, 0]).norm(dim=-1)  # (B, 3)
    taut = chord_m / now["rest_length_m"].clamp(min=1e-6) - TAUT_MIN
    traction_n = now["forces_n"][:, LEFT_ARM].norm(dim=-1, keepdim=True)
    return [
        tubes_there(now) * torch.tanh(taut / SLACK),
        torch.tanh((gap_m(now) - SPREAD_MIN_M) / GAP_M),
        torch.tanh((traction_n - GRASP_MIN_TRACTION_N) / TRACTION_N),
        torch.tanh((now["pinch_n"] - HELD_PINCH_N) / PINCH_N),
    ]


def gap_m(now: dict[str, Tensor]) -> Tensor:
    """Return (B, 1) the smallest distance between the left and the right tube's walls.

    The distance is over the tubes' middle halves.
    """
    quarter, n = TUBE_POINTS // 4, len(USUAL_TUBES)
    left, right = now["tubes_m"][:, :n, quarter : TUBE_POINTS - quarter].unbind(dim=1)
    apart_m = torch.cdist(left, right).flatten(1).amin(dim=1, keepdim=True)
    return apart_m - now["tube_radius_m"][:, :n].sum(dim=1, keepdim=True)


def tubes_there(now: dict[str, Tensor]) -> Tensor:
    """Return (B, 3) 1 where there is a tube, else 0, in the order of `TUBES`."""
    third = (now["third_tube"] > LIKELY).to(now["third_tube"])
    usual = torch.ones_like(third).expand(-1, len(USUAL_TUBES))
    return torch.cat([usual, third], dim=1)


def duct_is_left(now: dict[str, Tensor]) -> Tensor:
    """Return (B,) whether the left tube is the duct, whose upper end is nearer to the neck.

    The duct continues the gallbladder's neck, and the artery enters the wall beside the neck.
    """
    off_m = now["tubes_m"][:, : len(USUAL_TUBES), -1] - now["sac_m"][:, :1]
    left_m, right_m = off_m.norm(dim=-1).unbind(dim=1)
    return left_m <= right_m


def is_duct(now: dict[str, Tensor]) -> Tensor:
    """Return (B, 3) whether each of `TUBES` is the duct; a third tube is an artery."""
    left = duct_is_left(now)
    return torch.stack([left, ~left, torch.zeros_like(left)], dim=1)


def closed_clips(now: dict[str, Tensor]) -> Tensor:
    """Return (B, `MAX_CLIPS`) 1 where there is a clip, else 0."""
    slots = torch.arange(MAX_CLIPS, device=now["n_clips"].device)
    return (slots < now["n_clips"]).to(now["clips_m"].dtype)


def clips_along(tube_m: Tensor, length_m: Tensor, clips_m: Tensor, closed: Tensor) -> Sitting:
    """Find the clips on a tube, in their order along it.

    Args:
        tube_m: (B, n, 3) points of the tube's centreline.
        length_m: (B, 1) length of the tube at rest.
        clips_m: (B, m, 3) all clips.
        closed: (B, m) 1 where there is a clip, else 0.
    """
    share, distance_m = foot(tube_m, clips_m)
    station_m = share * length_m
    sits = (distance_m < SITS_WITHIN_M) & (closed > 0)
    order = torch.where(sits, station_m, torch.inf)
    first = order.topk(CLIPS_A_TUBE, dim=1, largest=False).indices
    return Sitting(
        places_m=clips_m.gather(1, first[..., None].expand(-1, -1, 3)),
        stations_m=station_m.gather(1, first),
        there=sits.gather(1, first).to(clips_m),
    )


def along_tube(tube_m: Tensor, length_m: Tensor, clips: Sitting, tip_m: Tensor) -> Tensor:
    """Return distances of a tip (B, 1, 3) from the tube's ends and its clips, coarse and fine.

    All distances are lengths of the tube at rest, as the judge measures them.

    The fine features are waves, because a network is insensitive to small differences in a number
    of order one. Source: Tancik et al., "Fourier features let networks learn high frequency
    functions", 2020.
    """
    station_m = foot(tube_m, tip_m).share * length_m
    apart_m = torch.cat([station_m, length_m - station_m, station_m - clips.stations_m], dim=1)
    there = torch.cat([torch.ones_like(apart_m[:, :2]), clips.there], dim=1)
    angles = [2.0 * math.pi * apart_m / wave_m for wave_m in WAVES_M]
    fine = [there * wave for angle in angles for wave in (angle.sin(), angle.cos())]
    coarse = [there * apart_m, clips.there * clips.stations_m]
    return torch.cat([*(part / LENGTH_M for part in coarse), *fine], dim=1)


def foot(tube_m: Tensor, points_m: Tensor) -> Foot:
    """Return the places on tubes (B, n, 3) that are nearest to points (B, m, 3)."""
    begin, along = tube_m[:, None, :-1], (tube_m[:, 1:] - tube_m[:, :-1])[:, None]  # (B, 1, n-1, 3)
    off = points_m[:, :, None] - begin  # (B, m, n-1, 3)
    share = ((off * along).sum(-1) / along.square().sum(-1).clamp(min=1e-12)).clamp(0.0, 1.0)
    distance_m, nearest = (off - share[..., None] * along).norm(dim=-1).min(dim=-1)
    beyond = share.gather(-1, nearest[..., None])[..., 0]
    return Foot((nearest + beyond) / (tube_m.shape[1] - 1), distance_m)
