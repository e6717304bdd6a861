"""Compute where clips and cut belong on the observed tubes, relative to the right tool.

The places follow from the rule of `tissue_sim.outcome.clip_rule` on the observation. A policy
without these places has to learn the rule from demonstrations. Such a policy placed clips 0.4 mm
off even with the exact state as input.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import torch
from torch import Tensor

from tissue_sim.outcome.clip_rule import (
    FEWEST_CLIPS,
    USUAL_CLIPS,
    clip_stations_m,
    cut_room_m,
    high_margin_m,
    needed_m,
    spacing_m,
)
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.sensing.observation import TUBE_POINTS
from tissue_sim.sensing.tissue_features import (
    FAR_SCALE_M,
    NEAR_SCALE_M,
    by_patient,
    clips_along,
    closed_clips,
    is_duct,
    per_tube,
    tubes_there,
)
from tissue_sim.sensing.tube_rule import by_tube
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import Instrument

FINE_M = 0.0015  # resolves a twentieth of a millimetre
SPARE_M = 0.004
NUMBERS = (USUAL_CLIPS, FEWEST_CLIPS)  # of clips on a tube: the words and the spare length choose

# Rows of `Places`, by the number of clips on the tube.
FIRST, SECOND = {USUAL_CLIPS: 0, FEWEST_CLIPS: 4}, 1
UPPER, CUT = {USUAL_CLIPS: 2, FEWEST_CLIPS: 5}, {USUAL_CLIPS: 3, FEWEST_CLIPS: 6}
LOWEST = {USUAL_CLIPS: 7, FEWEST_CLIPS: 8}  # where the upper clip leaves room for the cut


class Places(NamedTuple):
    """Places of a tube's clips and of its cut: for three clips (4 places), and for two (3).

    The last two places are the lowest for the upper clip of three and of two that leave room for
    the cut. B counts tubes, those of a patient side by side.

    Attributes:
        points_m: (B, 9, 3) points on the centreline, endoscope frame.
        along: (B, 9, 3) unit vectors along the tube, from its fixed end up.
        spare_m: (B, 2) excess of the tube's length over the need of each of `NUMBERS` clips.
    """

    points_m: Tensor
    along: Tensor
    spare_m: Tensor

    def on(self, k: int) -> Places:
        """Return the places on tube k of each patient alone."""
        return Places(*(part[k :: len(TUBES)] for part in self))


class TubeKind(NamedTuple):
    """What the clip rule depends on, of B tubes.

    Attributes:
        length_m: (B, 1) lengths at rest.
        is_duct: (B, 1) whether the tube is the duct.
        radius_m: (B, 1) outer radii.
    """

    length_m: Tensor
    is_duct: Tensor
    radius_m: Tensor

    def values(self, rule: Callable[[str, Instrument], Tensor | Sequence[float]]) -> Tensor:
        """Return m values (B, m) of the rule, by structure and applier."""
        return by_tube(self.is_duct, self.radius_m, lambda *kind: torch.as_tensor(rule(*kind)))


def places_on(now: dict[str, Tensor]) -> Places:
    """Return the places on all of `TUBES`; without a third tube its places mean nothing.

    Args:
        now: Parts of `Observation.vector()`, batched (B, ...).
    """
    tubes_m, closed = now["tubes_m"].flatten(0, 1), closed_clips(now)
    parts = now["rest_length_m"].clamp(min=1e-6), is_duct(now), now["tube_radius_m"]
    kind = TubeKind(*(part.reshape(-1, 1) for part in parts))
    seen = clips_along(tubes_m, kind.length_m, per_tube(now["clips_m"]), per_tube(closed))
    stations = _stations(kind, seen.stations_m, seen.there)
    points_m, along = _points(tubes_m, stations / kind.length_m)
    needs_m = kind.values(lambda tube, a: [needed_m(tube, a, n) for n in NUMBERS])
    return Places(points_m, along, kind.length_m - needs_m)


def place_features(now: dict[str, Tensor], places: Places) -> Tensor:
    """Return the places of clips and cut, from the right tip, coarse and fine, and spare lengths.

    Args:
        now: Parts of `Observation.vector()`, batched (B, ...).
        places: Places on each of `TUBES`.

    Returns:
        Features (B, 3, 83) of each tube; zeros without a third tube.
    """
    tip, there = per_tube(now["tips_endoscope"][:, RIGHT_ARM]), tubes_there(now).reshape(-1, 1)
    off = there[..., None] * (places.points_m - tip[:, None, :, 3])
    off_tool = torch.einsum("bji,bnj->bni", tip[..., :3], off).flatten(1)
    features = [
        off_tool / FAR_SCALE_M, torch.tanh(off_tool / NEAR_SCALE_M),
        torch.tanh(off_tool / FINE_M), there * torch.tanh(places.spare_m / SPARE_M),
    ]  # fmt: skip
    return by_patient(torch.cat(features, dim=1))


def _stations(kind: TubeKind, clips_m: Tensor, there: Tensor) -> Tensor:
    """Return (B, 9) stations of a tube's clips and of its cut, for each number of clips.

    A clip that sits farther up than its place in the rule moves the next clip up too.

    Args:
        kind: The tubes.
        clips_m: (B, m) stations of the clips on the tubes, in their order.
        there: (B, m) 1 where there is a clip.
    """
    margins_m = kind.values(lambda t, a: [high_margin_m(t, a), cut_room_m(a), spacing_m(a)])
    highest_m, cut_m, apart_m = margins_m.split(1, dim=1)
    highest_m = kind.length_m - highest_m
    found, lowest = list[Tensor](), list[Tensor]()
    for n in NUMBERS:
        planned = _planned(kind, n)
        found.append(planned[0])
        for k in range(1, n):
            room_m = cut_m if k == n - 1 else apart_m
            above_m = torch.maximum(planned[k], clips_m[:, k - 1, None] + room_m)
            moved_m = torch.minimum(above_m, highest_m)
            found.append(torch.where(there[:, k - 1, None] > 0, moved_m, planned[k]))
        lowest.append(_low(n, planned, clips_m, there) + cut_m)
        found.append(_cut(n, planned, clips_m, there))
    return torch.cat([*found, *lowest], dim=1)


def _planned(kind: TubeKind, n: int) -> tuple[Tensor, ...]:
    """Return the stations (B, 1) of n clips by the rule."""
    rule = partial(clip_stations_m, length_m=kind.length_m, n_clips=n)
    return kind.values(lambda t, a: torch.cat(rule(t, applier=a), dim=1)).split(1, dim=1)


def _low(n: int, planned: tuple[Tensor, ...], clips_m: Tensor, there: Tensor) -> Tensor:
    """Return (B, 1) the station where the upper one of the clips that stay sits, or belongs."""
    return torch.where(there[:, n - 2, None] > 0, clips_m[:, n - 2, None], planned[n - 2])


def _cut(n: int, planned: tuple[Tensor, ...], clips_m: Tensor, there: Tensor) -> Tensor:
    """Return (B, 1) the middle of the widest gap above the clips that stay, of n needed clips."""
    planned_m = 0.5 * (planned[-2] + planned[-1])
    low, high = clips_m[:, n - 2 : -1], clips_m[:, n - 1 :]
    gaps_m = torch.where(there[:, n - 1 :] > 0, high - low, -1.0)
    widest = gaps_m.argmax(dim=1, keepdim=True)
    middle_m = 0.5 * (low + high).gather(1, widest)
    return torch.where(there[:, n - 1, None] > 0, middle_m, planned_m)


def _points(tube_m: Tensor, share: Tensor) -> tuple[Tensor, Tensor]:
    """Return points and directions (B, m, 3) at shares (B, m) of tubes (B, n, 3).

    Beyond its ends a tube continues straight.
    """
    at = share * (TUBE_POINTS - 1)
    first = at.detach().floor().clamp(0, TUBE_POINTS - 2).long()
    rows = first[..., None].expand(-1, -1, 3)
    low, high = tube_m.gather(1, rows), tube_m.gather(1, rows + 1)
    way = high - low
    along = way / way.norm(dim=-1, keepdim=True).clamp(min=1e-6)
    return low + (at - first)[..., None] * way, along
