"""Compute the share of a straight joint motion that is free of collision, at any speed.

The method is conservative advancement (Mirtich, "Impulse-based dynamic simulation of rigid body
systems", 1996): step no farther than the present distances allow. If obstacle and link are convex,
the link stays on its side of a plane between them until one of its corners reaches the plane. So a
link may slide along an obstacle that it almost touches. Otherwise the way of every point is
bounded.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from controller.safety.geometry.collision import NO_LINK, CollisionModel, NearPairs
from controller.safety.geometry.link_cores import N_LINK, LinkCores, most_motion_m
from controller.safety.obstacles import LIVER, PORT_WALL, Surroundings
from tissue_sim.frames import Array
from tissue_sim.tools.instruments import Instrument

FAR_M = 1.0  # a room that no motion uses up
LITTLE = 1e-3  # of the remaining motion: too little for another look

Floor = Callable[[NearPairs], Array]  # (n,) smallest allowed distance of each pair, m


def free_share(
    model: CollisionModel,
    start: Array,
    end: Array,
    instruments: Sequence[Instrument],
    surroundings: Surroundings,
    *,
    floor_m: Floor,
    highest_m: float,
    near: NearPairs | None = None,
    most_looks: int,
) -> float:
    """Return the share, 0 to 1, of a straight joint motion that surely keeps all pairs apart.

    The surroundings are at rest. A pair that is nearer than allowed may move apart, if both sides
    are convex.

    Args:
        model: The collision model of the patient and both arms.
        start: (2, 7) joints at the start.
        end: (2, 7) joints at the end.
        instruments: Instruments on the left and right arm.
        surroundings: The present places of the obstacles.
        floor_m: Smallest allowed distance of each pair; minus infinity for an exempt pair.
        highest_m: The highest of the floors.
        near: The model's near pairs at the start, if known already.
        most_looks: Number of looks after which the rest of the motion counts as not free.
    """
    travel, bend = most_motion_m(start, end, instruments)
    if near is not None and _stays_off(near, floor_m, highest_m, travel):
        return 1.0
    last, sure = model.cores(end, instruments), 0.0
    for _ in range(most_looks):
        rest, joints = 1.0 - sure, start + sure * (end - start)
        first = near.links if near is not None else model.cores(joints, instruments)
        bends = rest * rest * bend
        farthest_m = _farthest_m(first, last)
        way_m = np.minimum(rest * travel, farthest_m + bends / 8.0)
        if near is None or not _holds_all(near, highest_m, way_m):
            within_m = highest_m + way_m[:N_LINK].max() + way_m[N_LINK:].max()
            near = model.near(joints, instruments, surroundings, within_m=within_m)
        room, ways = _room_m(near, floor_m), _of_pairs(near, way_m)
        rows = _may_meet(room, ways)
        if len(rows) == 0:
            return 1.0
        parting = _parting_m(near, last, farthest_m, rows)
        of_rows = (_of_pairs(near, of_links)[rows] for of_links in (rest * travel, bends))
        columns = (column.tolist() for column in (room[rows], parting, *of_rows))
        share = min(max(r / way, _above(r, p, b)) for r, p, way, b in zip(*columns, strict=True))
        if share == 1.0:
            return 1.0
        sure, near = sure + rest * share, None
        if share < LITTLE:
            break
    return sure


def _stays_off(near: NearPairs, floor_m: Floor, highest_m: float, way_m: Array) -> bool:
    """Return whether no pair can reach its floor on ways (8,)."""
    if not _holds_all(near, highest_m, way_m):
        return False
    return len(_may_meet(_room_m(near, floor_m), _of_pairs(near, way_m))) == 0


def _room_m(near: NearPairs, floor_m: Floor) -> Array:
    """Return the room (n,) above the floors."""
    return np.clip(near.distance_m - floor_m(near), 0.0, FAR_M)


def _may_meet(room: Array, ways: Array) -> NDArray[np.integer]:
    """Return the rows of pairs that may reach their floors on ways (n,) of both sides."""
    return np.flatnonzero((room <= ways) & (ways > 0.0))


def _farthest_m(first: LinkCores, last: LinkCores) -> Array:
    """Return the largest displacement (8,) of any point of each link from first to last."""
    chords = last.corners_m - first.corners_m
    return np.sqrt((chords * chords).sum(axis=2).max(axis=1))


def _holds_all(near: NearPairs, highest_m: float, way_m: Array) -> bool:
    """Return whether unlisted pairs cannot reach their floors on ways (8,)."""
    both_m = way_m[:N_LINK, None] + way_m[N_LINK:]
    among_arms = (near.others_m >= highest_m + both_m).all()
    return bool(near.within_m >= highest_m + way_m.max() and among_arms)


def _of_pairs(near: NearPairs, of_links: Array) -> Array:
    """Return (n,) the sum over both sides of each pair; `of_links` (8,)."""
    of_all = np.append(of_links, 0.0)
    return of_all[near.sides[0]] + of_all[near.sides[1]]


def _parting_m(
    near: NearPairs, last: LinkCores, farthest_m: Array, rows: NDArray[np.integer]
) -> Array:
    """Return the distances (n,) by which the rows' pairs move away from the plane between them.

    A surface need not lie on one side of a plane: each link counts as moving straight towards it.
    """
    n, other = near.normal[rows], near.other_link[rows]
    links = N_LINK * near.arm[rows] + near.link[rows]
    parting = last.lowest_m(links, n) - near.links.lowest_m(links, n)
    if len(both := np.flatnonzero(other != NO_LINK)):
        others, out = N_LINK + other[both], -n[both]
        parting[both] += last.lowest_m(others, out) - near.links.lowest_m(others, out)
    return np.where(near.of(LIVER, PORT_WALL)[rows], -_of_pairs(near, farthest_m)[rows], parting)


def _above(room: float, parting: float, bend: float) -> float:
    """Return the first t, at most 1, with room + t parting - bend t (1 - t) / 2 = 0.

    The expression bounds, from below, any function of t with a second derivative of at most `bend`.
    """
    slope = parting - 0.5 * bend
    under_root = slope * slope - 2.0 * bend * room
    if slope >= 0.0 or under_root < 0.0:
        return 1.0
    return min(2.0 * room / (sqrt(under_root) - slope), 1.0)
