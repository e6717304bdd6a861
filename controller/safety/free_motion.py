"""How much of a straight joint motion is free: nothing is jumped over, however fast it is.

Conservative advancement (Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996):
step no farther than the distances of now allow. Where obstacle and link are convex, a plane between
them is left on the link's side as long as no corner of the link comes down to it, so that a link
may slide along what it almost touches; elsewhere no point moves faster than the link lengths allow.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from controller.safety.chain_gaps import ALONGSIDE_M
from controller.safety.collision import NO_LINK, CollisionModel, NearPairs
from controller.safety.link_cores import N_LINK, LinkCores, most_motion_m
from controller.safety.surroundings import Surroundings
from tissue_sim.frames import Array
from tissue_sim.instruments import Instrument

MOST_LOOKS = 60
FAR_M = 1.0  # a room that is not used up
LITTLE = 1e-3  # of what is left of a motion: not worth another look

Floor = Callable[[NearPairs], Array]  # (n,) how near each pair may come, m


def anywhere_outside(near: NearPairs) -> Array:
    """Pairs may come as near as to touch."""
    return np.zeros(len(near.distance_m))


def free_share(
    model: CollisionModel,
    start: Array,
    end: Array,
    instruments: Sequence[Instrument],
    surroundings: Surroundings,
    *,
    floor_m: Floor = anywhere_outside,
    highest_m: float = 0.0,
    near: NearPairs | None = None,
    most_looks: int = MOST_LOOKS,
) -> float:
    """Of the straight line between joints (2, 7), what surely keeps all pairs apart, 0 to 1.

    The surroundings are at rest. A pair that is nearer than it may be may draw off, if both sides
    are convex.

    Args:
        floor_m: how near each pair may come; minus infinity for one that does not matter.
        highest_m: of the floors.
        near: what the model has at the start in these surroundings, if known already.
        most_looks: after as many the rest of the motion counts as not free.
    """
    travel, bend = most_motion_m(start, end, instruments)
    farthest_m = travel[:N_LINK].max() + travel[N_LINK:].max()
    sure, last = 0.0, None
    for _ in range(most_looks):
        rest, joints = 1.0 - sure, start + sure * (end - start)
        within_m = highest_m + rest * farthest_m
        if near is None or near.within_m < within_m:
            near = model.near(joints, instruments, surroundings, within_m=within_m)
        speed = rest * _of_pairs(near, travel)
        room = np.clip(near.distance_m - floor_m(near), 0.0, FAR_M)
        may_meet = (room <= speed) & (speed > 0.0)
        if not may_meet.any():
            return 1.0
        last = last or model.cores(end, instruments)
        parting = _parting_m(near, model.cores(joints, instruments), last)
        bends, hidden = rest * rest * _of_pairs(near, bend), _hidden_m(near, surroundings)
        figures = room, speed, bends, parting, hidden
        share = float(_Way(*(figure[may_meet] for figure in figures)).free_shares().min())
        sure, near = sure + rest * share, None
        if share < LITTLE:
            break
    return sure


def _of_pairs(near: NearPairs, of_links: Array) -> Array:
    """(n,) sum over both sides of each pair; `of_links` (8,)."""
    other = np.where(near.other_link == NO_LINK, 0.0, of_links[N_LINK + near.other_link])
    return of_links[N_LINK * near.arm + near.link] + other


def _parting_m(near: NearPairs, first: LinkCores, last: LinkCores) -> Array:
    """(n,) from first to last, how far each pair's links draw off from the plane between them."""
    link, n = N_LINK * near.arm + near.link, near.normal
    parting = last.lowest_m(link, n) - first.lowest_m(link, n)
    both = near.other_link != NO_LINK
    if both.any():
        other, down = N_LINK + near.other_link[both], -n[both]
        parting[both] += last.lowest_m(other, down) - first.lowest_m(other, down)
    return parting


def _hidden_m(near: NearPairs, surroundings: Surroundings) -> Array:
    """(n,) how far each obstacle rises above the plane, where it is not the convex part there."""
    hidden = np.where(near.other_link == NO_LINK, np.inf, 0.0)
    for name, chain in surroundings.chains.items():
        rows = near.obstacle == name
        if rows.any():
            n, points = near.normal[rows], np.concatenate([chain.start_m, chain.end_m])
            heights = points @ n.T + np.tile(chain.radius_m, 2)[:, None]
            hidden[rows] = heights.max(axis=0) - np.einsum("ni,ni->n", n, near.on_obstacle_m[rows])
    return hidden


@dataclass(frozen=True)
class _Way:
    """Of a motion, or what is left of it, what each pair (n,) may meet.

    Attributes:
        room: m, what distance there is above the floor.
        speed: m, by how much the two may near each other.
        bend: m, how much their ways bend.
        parting: m, how far they draw off from the plane between them.
        hidden: m, as `_hidden_m`.
    """

    room: Array
    speed: Array
    bend: Array
    parting: Array
    hidden: Array

    def free_shares(self) -> Array:
        """(n,) of the motion, what each pair keeps to its floor.

        By its speed; by the plane between link and capsule, before those that are `ALONGSIDE_M`
        farther can be there; by a plane that the whole obstacle is behind.
        """
        by_speed = self.room / self.speed
        of_part = np.minimum(self._above(self.room), (self.room + ALONGSIDE_M) / self.speed)
        below = np.maximum(self.room - self.hidden, 0.0)
        of_whole = np.where(below > 0.0, self._above(below), 0.0)
        by_plane = np.where(np.isfinite(self.hidden), np.maximum(of_part, of_whole), 0.0)
        return np.maximum(by_speed, by_plane)

    def _above(self, room: Array) -> Array:
        """(n,) first t, at most 1, with room + t parting - bend t (1 - t) / 2 = 0.

        A function of t whose second derivative is at most `bend` is nowhere farther below its
        chord.
        """
        slope = self.parting - 0.5 * self.bend
        under_root = slope * slope - 2.0 * self.bend * room
        falls = (slope < 0.0) & (under_root >= 0.0)
        root = np.ones(len(room))
        root[falls] = 2.0 * room[falls] / (np.sqrt(under_root[falls]) - slope[falls])
        return np.minimum(root, 1.0)
