"""Compute on which side of a place the right jaws have room beside observed structures at risk.

Low on a tube, the expert puts the jaws off the tube's middle. One finger then passes beside the
common bile duct or the hepatic artery. A policy without these structures as input stood beside the
first clip's place until a person was called. The safety filter kept its fingers off the structures.
"""

from __future__ import annotations

import torch
from torch import Tensor

from controller.diffusion.scene.places import FIRST, SECOND, Places
from controller.expert.motion import CLEARANCE_M, FIRM_ROOM_M, OFF_CENTRE_M
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, USUAL_CLIPS
from tissue_sim.patient.at_risk import COMMON_DUCT, HEPATIC_ARTERY, RADIUS_M
from tissue_sim.sensing.tissue_features import (
    FAR_SCALE_M,
    NEAR_SCALE_M,
    by_patient,
    duct_is_left,
    foot,
    per_tube,
    tubes_there,
)
from tissue_sim.sensing.tube_rule import by_tube
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import Instrument

LOW = (FIRST[USUAL_CLIPS], SECOND, FIRST[FEWEST_CLIPS])  # rows of `Places`
OFFS_M = (0.0, OFF_CENTRE_M, -OFF_CENTRE_M)  # along the tool's y, in the expert's order
ROOM_M = 0.001  # scale of the room beside a finger
PARTS = 6  # samples between the points of a structure at risk
BESIDE_M = 0.003  # of the point under the branch: the filter's


def side_features(now: dict[str, Tensor], places: Places) -> list[Tensor]:
    """Return the places of the structures at risk from the right tool, and the free side.

    Args:
        now: Parts of `Observation.vector()`, batched (B, ...).
        places: Places on each of `TUBES`.

    Returns:
        Features (B, ...) of three kinds. The first are points of the structures in the tool's
        frame, coarse and fine. The second are, for each low place and each of `OFFS_M`, the room
        beside the fingers beyond the least room. The third are the first offset with enough room,
        or the roomiest offset.
    """
    tip, lines_m = now["tips_endoscope"][:, RIGHT_ARM], lines_at_risk_m(now)
    off_tool = torch.einsum("bji,bnj->bni", tip[..., :3], lines_m - tip[:, None, :, 3])
    features = [off_tool / FAR_SCALE_M, torch.tanh(off_tool / NEAR_SCALE_M)]
    radius_m, there = now["tube_radius_m"].flatten(), tubes_there(now).reshape(-1, 1)
    rooms = rooms_m(places, per_tube(tip[..., 2]), radius_m, per_tube(lines_m))
    spare_m = rooms - FIRM_ROOM_M
    beside = torch.tanh(spare_m / ROOM_M).flatten(1), free_side(spare_m)
    return [*features, by_patient(there * torch.cat(beside, dim=1))]


def lines_at_risk_m(now: dict[str, Tensor]) -> Tensor:
    """Return points (B, 10, 3) of the common bile duct, then of the hepatic artery, in order.

    Each line also passes under its branch's first point, which lies on the structure's wall. There
    the branch draws the structure out.
    """
    left = duct_is_left(now)[:, None]
    left_m, right_m, _ = now["tubes_m"][:, :, 0].unbind(dim=1)
    duct_m, artery_m = torch.where(left, left_m, right_m), torch.where(left, right_m, left_m)
    return torch.cat(
        [
            _drawn_out(now["common_bile_duct_m"], duct_m, RADIUS_M[COMMON_DUCT]),
            _drawn_out(now["hepatic_artery_m"], artery_m, RADIUS_M[HEPATIC_ARTERY]),
        ],
        dim=1,
    )


def _drawn_out(trunk_m: Tensor, root_m: Tensor, radius_m: float) -> Tensor:
    """Return the points of a trunk (B, 4, 3), and the point under its branch's root (B, 3).

    That point is found as in `controller.safety.seen_obstacles.trunk_line`. A point of the trunk
    that is closer to it than `BESIDE_M` is replaced by it.
    """
    line_m = _finer(trunk_m)
    share, _ = foot(line_m, root_m[:, None])
    at = share * (line_m.shape[1] - 1)
    first = at.detach().floor().clamp(0, line_m.shape[1] - 2).long()[..., None].expand(-1, -1, 3)
    low_m, high_m = line_m.gather(1, first)[:, 0], line_m.gather(1, first + 1)[:, 0]
    place_m = low_m + (at - first[..., 0]) * (high_m - low_m)
    under_m = (root_m + radius_m * _unit(place_m - root_m))[:, None]
    beside = (trunk_m - under_m).norm(dim=-1, keepdim=True) < BESIDE_M
    whole_m = torch.cat([torch.where(beside, under_m, trunk_m), under_m], dim=1)
    way = (trunk_m[:, 3] - trunk_m[:, 0])[:, None]
    order = ((whole_m - trunk_m[:, :1]) * way).sum(-1).argsort(dim=1)
    return whole_m.gather(1, order[..., None].expand(-1, -1, 3))


def _unit(vectors: Tensor) -> Tensor:
    return vectors / vectors.norm(dim=-1, keepdim=True).clamp(min=1e-6)


def _square(vectors: Tensor, along: Tensor) -> Tensor:
    """Return the part of vectors that is square to unit vectors."""
    return vectors - (vectors * along).sum(-1, keepdim=True) * along


def rooms_m(places: Places, forward: Tensor, tube_radius_m: Tensor, lines_m: Tensor) -> Tensor:
    """Return the room between the open fingers and the structures at risk; negative if inside.

    The measure is that of `controller.expert.jaw_room.firm_room_m` for the expert's usual approach,
    on observed structures.

    Args:
        places: The places on B tubes; the low ones count.
        forward: (B, 3) the tool's direction, which is turned square to the tube at a place.
        tube_radius_m: (B,) radii of the tubes, for which the jaws open wide enough.
        lines_m: The lines that `lines_at_risk_m` returns.

    Returns:
        (B, 3, 3) room at each of the low places, for each of `OFFS_M`.
    """
    bile_duct_m, hepatic_m = (_finer(line) for line in lines_m.chunk(2, dim=1))
    lines_m = torch.cat([bile_duct_m, hepatic_m], dim=1)
    wide_m = [RADIUS_M[COMMON_DUCT]] * bile_duct_m.shape[1]
    wide_m += [RADIUS_M[HEPATIC_ARTERY]] * hepatic_m.shape[1]
    radii_m = torch.tensor(wide_m, dtype=lines_m.dtype, device=lines_m.device)
    radius_m = tube_radius_m[:, None, None]
    mouth_m, thick_m, to_tip_m, start_m, wide_m = _sizes_m(radius_m).split(1, dim=-1)
    x, y, z = _in_jaws(places, forward, lines_m, mouth_m)  # (B, 3, samples) each
    finger_m = to_tip_m - start_m
    opening = (radius_m + CLEARANCE_M) / (to_tip_m - 0.5 * mouth_m)
    half_rad = opening.clamp(0.0, 0.9).asin()  # the expert's opening, which barely clears a tube
    beside = (x.abs() - wide_m).clamp(min=0.0)
    beyond = torch.maximum(z, (-finger_m - z).clamp(min=0.0))
    from_pivot_m = to_tip_m + torch.maximum(z, -finger_m).clamp(max=0.0)
    middle = from_pivot_m * half_rad.tan() + thick_m * (2.0 / half_rad.cos() - 1.0)
    offs_m = torch.tensor(OFFS_M, device=y.device)[:, None]
    across = (y[:, :, None] - offs_m).abs() - middle[:, :, None]
    off_axis = (beside.square() + beyond.square())[:, :, None]
    away_m = (off_axis + across.square()).sqrt()
    return (away_m - thick_m[..., None] - radii_m).amin(dim=-1)


def _sizes_m(radius_m: Tensor) -> Tensor:
    """Return sizes (B, 1, 5) of the appliers for tubes of these radii (B, 1, 1).

    They are the mouth's length, a finger's half thickness, the distances of its tip and of its
    begin from the yaw axis, and its half width.
    """

    def sizes(_: str, tool: Instrument) -> Tensor:
        return torch.tensor(
            [
                tool.mouth_m[0],
                tool.finger_half_thickness_m,
                tool.yaw_to_tip_m,
                tool.finger_start_m,
                tool.finger_half_width_m,
            ]
        )

    return by_tube(torch.ones_like(radius_m, dtype=torch.bool), radius_m, sizes)


def _finer(points_m: Tensor) -> Tensor:
    """Return `PARTS` samples of each piece of smooth lines through points (B, n, 3).

    The pieces are cubic Hermite curves. Their slopes at the points are those of parabolas through
    neighbours.
    """
    chord_m = (points_m[:, 1:] - points_m[:, :-1]).norm(dim=-1, keepdim=True).clamp(min=1e-6)
    slope = (points_m[:, 1:] - points_m[:, :-1]) / chord_m
    before, after = chord_m[:, :-1], chord_m[:, 1:]
    inner = (after * slope[:, :-1] + before * slope[:, 1:]) / (before + after)
    first, last = 2.0 * slope[:, :1] - inner[:, :1], 2.0 * slope[:, -1:] - inner[:, -1:]
    at_points = torch.cat([first, inner, last], dim=1)
    start, end = points_m[:, :-1, None], points_m[:, 1:, None]
    leaving = (chord_m * at_points[:, :-1])[:, :, None]
    arriving = (chord_m * at_points[:, 1:])[:, :, None]
    t = (torch.arange(PARTS, device=points_m.device) / PARTS)[:, None]
    turning = start + t * leaving + t**2 * (3.0 * (end - start) - 2.0 * leaving - arriving)
    return (turning + t**3 * (2.0 * (start - end) + leaving + arriving)).flatten(1, 2)


def _in_jaws(
    places: Places, forward: Tensor, lines_m: Tensor, mouth_m: Tensor
) -> tuple[Tensor, Tensor, Tensor]:
    """Return coordinates (B, 3, n) of points (B, n, 3) in the frame of a tool at each low place.

    The middle of the tool's mouth, of a length (B, 1, 1), is at the place.
    """
    x, points_m = places.along[:, LOW], places.points_m[:, LOW]
    z = _unit(_square(forward[:, None], x))
    y = torch.linalg.cross(z, x)
    off = lines_m[:, None] - points_m[:, :, None]
    along, across, ahead = ((off * axis[:, :, None]).sum(-1) for axis in (x, y, z))
    return along, across, ahead - 0.5 * mouth_m


def free_side(spare_m: Tensor) -> Tensor:
    """Return (B, 3) -1, 0 or 1: the side to which jaws go, from the spare room (B, 3, 3)."""
    enough = (spare_m > 0.0).to(spare_m)
    order = torch.tensor([3.0, 2.0, 1.0], device=spare_m.device)
    chosen = torch.where(
        enough.amax(dim=-1) > 0.0, (enough * order).argmax(dim=-1), spare_m.argmax(dim=-1)
    )
    sides = torch.tensor([0.0, 1.0, -1.0], device=spare_m.device)
    return sides[chosen]
