"""Move a pulled clip: beyond its hold it slides along its tube, and over the end it detaches.

The motion is quasi-static, as friction is: while the pull exceeds the hold, the clip slides at a
constant speed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import (
    Clip,
    T_world_clip,
    detach,
    holding_forces_n,
    release,
    springs_in,
    squeeze,
)
from tissue_sim.surgery.wall_squeeze import rings_of

SLIP_SPEED_M_S = 0.02  # assumed: speed of a pulling hand


@dataclass(frozen=True, kw_only=True)
class Pull:
    """A pull on one clip, N.

    Attributes:
        number: number of the clip.
        force_world_n: (3,) force in the world frame.
        grip_n: the clip's grip before the pull, because the pull tightens the tissue and not the
            clip.
    """

    number: int
    force_world_n: Array
    grip_n: float


def apply_pull(tubes: Tubes, clip: Clip, pull: Pull, step_s: float) -> Clip:
    """Return the pulled clip after a step: unchanged, displaced or detached.

    Pulls along (F) and across (G) add up as friction does. The clip moves when

        (F / hold along)^2 + (G / hold across)^2 > 1.

    Under a pull across, or with two tubes between its legs, a clip does not slide but detaches.
    """
    if clip.lost or not pull.force_world_n.any():
        return clip
    crossing = clip.crossings[0]
    _, tangent = tubes.point(crossing.tube, crossing.station_m)
    along = float(pull.force_world_n @ tangent)
    across = float(np.linalg.norm(pull.force_world_n - along * tangent))
    holds_along, holds_across = holding_forces_n(tubes, clip, pull.grip_n)
    if not (holds_along > 0.0 and holds_across > 0.0) or across > holds_across:
        return detach(tubes, clip)
    if (along / holds_along) ** 2 + (across / holds_across) ** 2 <= 1.0:
        return clip
    if len(clip.crossings) > 1:
        return detach(tubes, clip)
    return slide(tubes, clip, float(np.copysign(SLIP_SPEED_M_S * step_s, along)))


def slide(tubes: Tubes, clip: Clip, by_m: float) -> Clip:
    """Move a clip on one tube along it, and its squeeze from ring to ring.

    The clip detaches at a severed end, and stops at an end that is joined to the body.
    """
    (crossing,) = clip.crossings
    tube = crossing.tube
    first, last = tubes.stump(tube, crossing.station_m)
    stations = tubes.stations_m[tube]
    station = float(np.clip(crossing.station_m + by_m, stations[first], stations[last]))
    if station in tubes.free_ends_m(tube):
        return detach(tubes, clip)
    by_m = station - crossing.station_m
    ring = first + int(np.argmin(np.abs(stations[first : last + 1] - station)))
    clip = _on_rings(tubes, clip, ring - crossing.ring) if ring != crossing.ring else clip
    # the clip's frame moves the opposite way relative to the clipped tissue
    _, tangent = tubes.point(tube, crossing.station_m)
    by_clip_m = T_world_clip(tubes, clip)[:3, :3].T @ tangent * by_m
    return replace(
        clip,
        crossings=(replace(crossing, station_m=station, ring=ring),),
        places_m=clip.places_m - by_clip_m,
        slid_m=clip.slid_m + abs(by_m),
    )


def update_after_cut(tubes: Tubes, clip: Clip) -> Clip:
    """Return the clip after a cut: a ring severed under its legs stays on its own stump."""
    there = {
        int(old): int(new)
        for crossing, rings in zip(clip.crossings, clip.rings, strict=True)
        for r in rings
        for old, new in zip(
            tubes.below[crossing.tube][r],
            tubes.side(crossing.tube, crossing.station_m)[r],
            strict=True,
        )
    }
    if clip.lost or all(there.get(v, v) == v for v in clip.vertices):
        return clip
    return _on_vertices(tubes, clip, {v: there.get(v, v) for v in clip.vertices})


def update_after_hole(tubes: Tubes, clip: Clip) -> Clip:
    """Return the clip after a hole in the gallbladder: what is left of the wall stays held."""
    if not clip.sac_rings:
        return clip
    sac = tubes.organ.sac_rings
    gone = set(sac[tubes.tissue.host("fixed")[tubes.b, sac] != 0].tolist())  # without an element
    if gone.isdisjoint(clip.vertices):
        return clip
    clip = _on_vertices(tubes, clip, {v: v for v in clip.vertices if v not in gone})
    return replace(clip, sac_rings=rings_of(tubes.organ, springs_in(tubes, clip.links)))


def _on_rings(tubes: Tubes, clip: Clip, shift: int) -> Clip:
    """Move the squeeze by a number of rings; release vertices beyond the stump's end.

    A clip that slides off the gallbladder's neck releases the neck.
    """
    (crossing,), (rings,) = clip.crossings, clip.rings
    tube, station = crossing.tube, crossing.station_m
    first, last = tubes.stump(tube, station)
    side = tubes.side(tube, station)
    kept = [r for r in rings if first <= r + shift <= last]
    there = {
        int(old): int(new) for r in kept for old, new in zip(side[r], side[r + shift], strict=True)
    }
    move_m = np.subtract(*tubes.stations_m[tube][[crossing.ring + shift, crossing.ring]])
    _, tangent = tubes.point(tube, station)
    by_clip_m = T_world_clip(tubes, clip)[:3, :3].T @ tangent * move_m
    clip = _on_vertices(tubes, clip, there)
    return replace(
        clip,
        rings=(tuple(r + shift for r in kept),),
        sac_rings=(),
        places_m=clip.places_m + by_clip_m,
    )


def _on_vertices(tubes: Tubes, clip: Clip, there: dict[int, int]) -> Clip:
    """Replace the vertices that the clip holds; release those that are not in `there`."""
    springs = [
        (there[i], there[j], rest, stiffness)
        for i, j, rest, stiffness in springs_in(tubes, clip.links)
        if i in there and j in there
    ]
    held = [there[v] for v in clip.vertices if v in there]
    release(tubes, clip.links, clip.vertices)
    return replace(
        clip,
        links=squeeze(tubes, springs, held),
        vertices=tuple(held),
        places_m=clip.places_m[[v in there for v in clip.vertices]],
    )
