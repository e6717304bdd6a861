"""All pairs of instrument and obstacle that are near each other, with distance and direction."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from controller.safety.chain_gaps import chain_gaps
from controller.safety.core_gaps import CORE_GAP, NO_LINK, CoreGaps
from controller.safety.gap import MM, Gap, gap
from controller.safety.link_cores import N_LINK, SHAFT, LinkCores, link_cores
from controller.safety.rigid_surface import SurfaceModel
from controller.safety.slabs import Slabs, half_a_sphere, joined
from controller.safety.surroundings import (
    LIVER,
    PORT_WALL,
    RigidSurroundings,
    Surroundings,
)
from tissue_sim.frames import Array
from tissue_sim.instruments import Instrument
from tissue_sim.sweep import Indices

ACTIVATION_M = 0.010
OTHER_ARM = "right arm"  # the obstacle's name for links of the left arm
N_DIRECTION = 32
Pair = tuple[int, int, str, int]  # arm, link, obstacle, other link
_SHAFTS = [SHAFT, N_LINK + SHAFT]


@dataclass(frozen=True, kw_only=True)
class NearPairs:
    """Pairs that are nearer than the activation distance: a row a pair, world frame, m.

    `on_instrument_m` - `on_obstacle_m` = `distance_m` * `normal`, also under penetration.

    Attributes:
        distance_m: (n,) signed, below 0: this deep in the obstacle.
        on_instrument_m: (n, 3) nearest, or deepest, point of the instrument's surface.
        on_obstacle_m: (n, 3) nearest point of the obstacle's surface.
        normal: (n, 3) unit, from the obstacle to the instrument: the shortest way out.
        arm: (n,) 0 left, 1 right.
        link: (n,) index into `PATCH_LINKS`.
        other_link: (n,) of the right arm where that is the obstacle, -1 elsewhere. Such a pair
            is there once, with the left arm as the instrument.
        obstacle: (n,) "liver", "port wall", "right arm", or the name of a chain.
        within_m: the activation distance.
    """

    distance_m: Array
    on_instrument_m: Array
    on_obstacle_m: Array
    normal: Array
    arm: Indices
    link: Indices
    other_link: Indices
    obstacle: NDArray[np.str_]
    within_m: float

    def pair(self, row: int) -> Pair:
        """Who is near to what; the capsules of a chain are one obstacle."""
        return (
            int(self.arm[row]),
            int(self.link[row]),
            str(self.obstacle[row]),
            int(self.other_link[row]),
        )


class CollisionModel:
    """Of one patient, for both arms: surfaces are built here, once, and only moved later."""

    def __init__(self, rigid: RigidSurroundings, T_world_rcm: Array) -> None:
        """`T_world_rcm` (2, 4, 4): where the remote centres are."""
        self._T_world_rcm = T_world_rcm
        self._surfaces = {
            LIVER: SurfaceModel(rigid.liver),
            PORT_WALL: SurfaceModel(rigid.port_wall),
        }
        surfaces = self._surfaces.values()
        self._directions = np.stack([*half_a_sphere(N_DIRECTION), *(s.outward for s in surfaces)])
        self._slabs = joined([s.slabs(self._directions) for s in surfaces])

    def cores(self, joints: Array, instruments: Sequence[Instrument]) -> LinkCores:
        """Where the instruments are at joints (2, 7)."""
        return link_cores(joints, instruments, self._T_world_rcm)

    def near(
        self,
        joints: Array,
        instruments: Sequence[Instrument],
        surroundings: Surroundings,
        *,
        within_m: float = ACTIVATION_M,
    ) -> NearPairs:
        """Every pair nearer than `within_m`, at joints (2, 7).

        Of one link and one surface, one pair; of one link and one chain, the nearest capsule and
        those alongside, at most `ALONGSIDE_M` farther. A shaft and the port wall are no pair: it
        goes through it, and is inside the flat wall as far as its wrist, which is checked.
        """
        links = self.cores(joints, instruments)
        chains = surroundings.chains
        names = [*chains, *self._surfaces, OTHER_ARM]
        slabs = links.slabs(self._directions)
        by_fcl = [
            *self._surface_gaps(links, slabs, surroundings, within_m),
            *_gaps_between_arms(links, slabs, len(names) - 1, within_m),
        ]
        by_form = chain_gaps(links, list(chains.values()), within_m)
        gaps = np.empty(len(by_fcl) + len(by_form), CORE_GAP)
        gaps[: len(by_fcl)], gaps[len(by_fcl) :] = by_fcl, by_form
        return _near_pairs(gaps, links.radius_m, names, within_m)

    def _surface_gaps(
        self, links: LinkCores, slabs: Slabs, surroundings: Surroundings, within_m: float
    ) -> Iterator[tuple]:
        moved_m = np.stack([surroundings.moved_m[name] for name in self._surfaces])
        surfaces = self._slabs.moved(moved_m @ self._directions.T)
        near = slabs.at_least_m(surfaces) < within_m
        for k, (name, surface) in enumerate(self._surfaces.items()):
            surface.move(moved_m[k])
            near[_SHAFTS, k] &= name != PORT_WALL
            for link in np.flatnonzero(near[:, k]).tolist():
                yield _row(link, len(surroundings.chains) + k, surface.gap(links.core(link)))


def _gaps_between_arms(
    links: LinkCores, slabs: Slabs, obstacle: int, within_m: float
) -> Iterator[tuple]:
    near = slabs[:N_LINK].at_least_m(slabs[N_LINK:]) < within_m
    for k, other in np.argwhere(near).tolist():
        between = gap(links.core(k), links.core(N_LINK + other))
        yield _row(k, obstacle, between, other, links.radius_m[N_LINK + other])


def _row(
    link: int, obstacle: int, gap: Gap, other_link: int = NO_LINK, radius_m: float = 0.0
) -> tuple:
    """Of `CORE_GAP`."""
    return link, obstacle, other_link, gap.distance_mm / MM, gap.a_mm / MM, gap.b_mm / MM, radius_m


def _near_pairs(gaps: CoreGaps, radius_m: Array, names: list[str], within_m: float) -> NearPairs:
    """The rows with the radii put on; `radius_m` (8,) of the links."""
    radii = radius_m[gaps["link"]], gaps["other_radius_m"]
    distance = gaps["apart_m"] - radii[0] - radii[1]
    kept = distance < within_m
    rows = gaps[kept]
    radius, radius_other = (r[kept, None] for r in radii)
    on_link, on_other = rows["on_link_m"], rows["on_other_m"]
    normal = (on_link - on_other) / rows["apart_m"][:, None]
    arm, link = np.divmod(rows["link"], N_LINK)
    return NearPairs(
        distance_m=distance[kept],
        on_instrument_m=on_link - radius * normal,
        on_obstacle_m=on_other + radius_other * normal,
        normal=normal,
        arm=arm,
        link=link,
        other_link=rows["other_link"],
        obstacle=np.array(names)[rows["obstacle"]],
        within_m=within_m,
    )
