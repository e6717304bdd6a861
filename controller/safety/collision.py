"""All pairs of instrument and obstacle that are near each other, with distance and direction."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controller.safety.chain_search import ChainSearch
from controller.safety.gap import MM, Core, Gap, gap
from controller.safety.link_cores import N_LINK, SHAFT, LinkCores, link_cores
from controller.safety.rigid_surface import SurfaceModel
from controller.safety.surroundings import (
    LIVER,
    PORT_WALL,
    CapsuleChain,
    RigidSurroundings,
    Surroundings,
)
from tissue_sim.frames import Array
from tissue_sim.instruments import Instrument
from tissue_sim.sweep import Indices

ACTIVATION_M = 0.010
OTHER_ARM = "right arm"  # the obstacle's name for links of the left arm
NO_LINK = -1
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
    """

    distance_m: Array
    on_instrument_m: Array
    on_obstacle_m: Array
    normal: Array
    arm: Indices
    link: Indices
    other_link: Indices
    obstacle: NDArray[np.str_]


class CollisionModel:
    """Of one patient, for both arms: surfaces are built here, once, and only moved later."""

    def __init__(self, rigid: RigidSurroundings, T_world_rcm: Array) -> None:
        """`T_world_rcm` (2, 4, 4): where the remote centres are."""
        self._T_world_rcm = T_world_rcm
        self._surfaces = {
            LIVER: SurfaceModel(rigid.liver),
            PORT_WALL: SurfaceModel(rigid.port_wall),
        }

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
        those that had to be looked at to know it. A shaft and the port wall are no pair: it goes
        through its hole, and is inside the flat wall as far as its wrist, which is checked.
        """
        links = link_cores(joints, instruments, self._T_world_rcm)
        cores = links.cores()
        found = [
            *self._near_surfaces(links, cores, surroundings.moved_m, within_m),
            *_near_chains(links, cores, surroundings.chains, within_m),
            *_between_arms(links, cores, within_m),
        ]
        return _near_pairs(found, links.radius_m, within_m)

    def _near_surfaces(
        self, links: LinkCores, cores: list[Core], moved_m: Mapping[str, Array], within_m: float
    ) -> Iterator[_Near]:
        for name, surface in self._surfaces.items():
            surface.move(moved_m[name])
            near = surface.at_least_m(links) < within_m
            near[_SHAFTS] &= name != PORT_WALL
            for k in np.flatnonzero(near).tolist():
                yield _Near(link=k, obstacle=name, gap=surface.gap(cores[k]), radius_m=0.0)


class _Near(NamedTuple):
    """A link (0 to 7), what it is near, the gap between their cores, and the other's radius."""

    link: int
    obstacle: str
    gap: Gap
    radius_m: float
    other_link: int = NO_LINK


def _near_chains(
    links: LinkCores, cores: list[Core], chains: Mapping[str, CapsuleChain], within_m: float
) -> Iterator[_Near]:
    search, names = ChainSearch(chains), list(chains)
    for link, chain, capsule, between in search.near(links, cores, within_m):
        yield _Near(link, names[chain], between, search.radius_m[capsule])


def _between_arms(links: LinkCores, cores: list[Core], within_m: float) -> Iterator[_Near]:
    extent = np.hypot(*links.half_size_m.T) + links.radius_m
    apart = links.to_points_m(links.centre_m) - extent
    bound = np.maximum(apart, apart.T)[:N_LINK, N_LINK:]
    for k, other in np.argwhere(bound < within_m).tolist():
        between = gap(cores[k], cores[N_LINK + other])
        yield _Near(k, OTHER_ARM, between, links.radius_m[N_LINK + other], other)


def _near_pairs(found: list[_Near], radius_m: Array, within_m: float) -> NearPairs:
    """The rows with the radii put on; `radius_m` (8,) of the links."""
    gaps = [near.gap for near in found]
    cores_apart = np.array([[g.distance_mm] for g in gaps]).reshape(-1, 1) / MM
    on_a = np.array([g.a_mm for g in gaps]).reshape(-1, 3) / MM
    on_b = np.array([g.b_mm for g in gaps]).reshape(-1, 3) / MM
    link = np.array([near.link for near in found], np.int32)
    radius, radius_other = radius_m[link, None], np.array([n.radius_m for n in found])[:, None]
    normal = (on_a - on_b) / cores_apart
    distance = (cores_apart - radius - radius_other)[:, 0]
    kept = distance < within_m
    return NearPairs(
        distance_m=distance[kept],
        on_instrument_m=(on_a - radius * normal)[kept],
        on_obstacle_m=(on_b + radius_other * normal)[kept],
        normal=normal[kept],
        arm=link[kept] // N_LINK,
        link=link[kept] % N_LINK,
        other_link=np.array([near.other_link for near in found], np.int32)[kept],
        obstacle=np.array([near.obstacle for near in found], str)[kept],
    )
