"""Find all pairs of instrument and obstacle near each other, with distance and direction."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from controller.safety.geometry.gap import MM, TOUCHING_MM, Core, Gap, gap, overlap
from controller.safety.geometry.link_cores import N_LINK, SHAFT, LinkCores, link_cores
from controller.safety.geometry.rigid_surface import SurfaceModel
from controller.safety.geometry.segment_gap import segment_gaps
from controller.safety.geometry.slabs import half_a_sphere, joined
from controller.safety.obstacles import (
    LIVER,
    PORT_WALL,
    Capsules,
    RigidSurroundings,
    Surroundings,
    with_assistant,
)
from tissue_sim.frames import Array
from tissue_sim.patient.mesher import Indices
from tissue_sim.tools.instruments import Instrument

ACTIVATION_M = 0.010  # pairs farther apart set no bound; must exceed `NEAR_AT_RISK_M`; assumed
OTHER_ARM = "right arm"  # the obstacle's name for links of the left arm
N_DIRECTION = 32
ALONGSIDE_M = 0.001  # assumed: capsules hardly farther than the nearest one of a chain
Pair = tuple[int, int, str, int]  # arm, link, obstacle, other link
_SHAFTS = [SHAFT, N_LINK + SHAFT]
NO_LINK = -1
NO_CAPSULE = np.iinfo(np.int32).max

# A table of the gaps between the links' cores and near obstacles: one row per pair.
CORE_GAP = np.dtype(
    [
        ("link", np.int32),  # 0 to 7, left arm first
        ("obstacle", np.int32),  # in a list of names
        ("other_link", np.int32),  # 0 to 3, of the right arm where that is the obstacle
        ("apart_m", float),  # below 0: this deep
        ("on_link_m", float, 3),  # nearest points of the cores, world frame
        ("on_other_m", float, 3),
        ("other_radius_m", float),  # about the other's core
        ("foremost", bool),  # of a chain, nearest to the link or hardly farther
        ("capsule", np.int32),  # among all chains' capsules; `NO_CAPSULE` of other obstacles
    ]
)
CoreGaps = NDArray[np.void]  # (n,) of CORE_GAP


@dataclass(frozen=True, kw_only=True)
class NearPairs:
    """Pairs that are nearer than the activation distance: one row per pair, world frame, m.

    `on_instrument_m` - `on_obstacle_m` = `distance_m` * `normal`, also under penetration.

    Attributes:
        distance_m: (n,) signed distance; a negative distance is the depth in the obstacle.
        on_instrument_m: (n, 3) nearest, or deepest, point of the instrument's surface.
        on_obstacle_m: (n, 3) nearest point of the obstacle's surface.
        normal: (n, 3) unit vector from the obstacle to the instrument: the shortest way out.
        arm: (n,) 0 left, 1 right.
        link: (n,) index into `PATCH_LINKS`.
        other_link: (n,) link of the right arm where the right arm is the obstacle, -1 elsewhere.
            Such a pair exists once, with the left arm as the instrument.
        names: Names of all obstacles: the chains' names with "assistant's grasper", then "liver",
            "port wall" and "right arm".
        what: (n,) index into `names`.
        foremost: (n,) mask of the capsules of a chain that are nearest or hardly farther.
        capsule: (n,) index of the obstacle's capsule, `NO_CAPSULE` where the obstacle is none.
        within_m: The activation distance.
        others_m: (4, 4) lower bounds of the distances between links of the left and right arm that
            are no pair; infinite for a pair.
        links: The links of both instruments.
    """

    distance_m: Array
    on_instrument_m: Array
    on_obstacle_m: Array
    normal: Array
    arm: Indices
    link: Indices
    other_link: Indices
    names: tuple[str, ...]
    what: Indices
    foremost: NDArray[np.bool_]
    capsule: Indices
    within_m: float
    others_m: Array
    links: LinkCores

    def of(self, *names: str) -> NDArray[np.bool_]:
        """Return the mask (n,) of pairs whose obstacle has one of these names."""
        return _among(self.names, names)[self.what]

    @cached_property
    def sides(self) -> Indices:
        """Return the rows (2, n) of each pair in `links`; one past the end for an obstacle."""
        other = np.where(self.other_link == NO_LINK, 2 * N_LINK, N_LINK + self.other_link)
        return np.stack([N_LINK * self.arm + self.link, other])

    def pair(self, row: int) -> Pair:
        """Return arm, link, obstacle and other link; a chain's capsules are one obstacle."""
        return (
            int(self.arm[row]),
            int(self.link[row]),
            self.names[self.what[row]],
            int(self.other_link[row]),
        )


class CollisionModel:
    """Finds near pairs of one patient and both arms; surfaces are built once, then only moved."""

    def __init__(self, rigid: RigidSurroundings, T_world_rcm: Array) -> None:
        """Build the surfaces; `T_world_rcm` (2, 4, 4) are the remote centres."""
        self._T_world_rcm, self._assistant_m = T_world_rcm, rigid.assistant_m
        self._surfaces = {
            LIVER: SurfaceModel(rigid.liver),
            PORT_WALL: SurfaceModel(rigid.port_wall),
        }
        surfaces = self._surfaces.values()
        self._directions = np.stack([*half_a_sphere(N_DIRECTION), *(s.outward for s in surfaces)])
        slabs = [s.slabs(self._directions) for s in surfaces]
        self._slabs, self._n_patch = joined(slabs), [len(s.low_m) for s in slabs]
        self._first_patch = np.cumsum([0, *self._n_patch[:-1]])

    def cores(self, joints: Array, instruments: Sequence[Instrument]) -> LinkCores:
        """Return the instruments' cores at joints (2, 7)."""
        return link_cores(joints, instruments, self._T_world_rcm)

    def near(
        self,
        joints: Array,
        instruments: Sequence[Instrument],
        surroundings: Surroundings,
        *,
        within_m: float = ACTIVATION_M,
    ) -> NearPairs:
        """Return every pair nearer than `within_m`, at joints (2, 7).

        A link and a surface are one pair; a link and a chain have a pair for each capsule. A shaft
        and the port wall are no pair, because the shaft passes through the wall. The wrist is
        checked instead.
        """
        links = self.cores(joints, instruments)
        moved_m = np.stack([surroundings.moved_m[name] for name in self._surfaces])
        chains = with_assistant(surroundings, self._assistant_m)
        names = (*chains.names, *self._surfaces, OTHER_ARM)
        surfaces, arms_m = self._at_least_m(links, moved_m)
        arms = arms_m < within_m
        cores = cache(links.core)
        rows = [
            *self._surface_rows(cores, surfaces < within_m, moved_m, len(chains.names)),
            *_rows_between_arms(cores, arms, links.radius_m, len(names) - 1),
        ]
        by_form, by_fcl = chain_gaps(links, chains, within_m), np.array(rows, CORE_GAP)
        distance_m = _distance_m(by_fcl, links.radius_m)
        far = distance_m >= within_m
        of_arms = by_fcl["other_link"] != NO_LINK
        pairs = by_fcl[of_arms]
        arms_m[pairs["link"], pairs["other_link"]] = np.where(far, distance_m, np.inf)[of_arms]
        by_fcl = by_fcl[~far]
        gaps = np.empty(len(by_fcl) + len(by_form), CORE_GAP)
        gaps[: len(by_fcl)], gaps[len(by_fcl) :] = by_fcl, by_form
        return _near_pairs(gaps, links, names, within_m, arms_m)

    def _at_least_m(self, links: LinkCores, moved_m: Array) -> tuple[Array, Array]:
        """Return lower bounds of distances: surfaces to links (2, 8), and between arms (4, 4)."""
        slabs = links.slabs(self._directions)
        moved_m = np.repeat(moved_m @ self._directions.T, self._n_patch, axis=0)
        others = joined([self._slabs.moved(moved_m), slabs[N_LINK:]])
        apart = others.at_least_m(slabs)
        patches, arms = apart[:-N_LINK], apart[-N_LINK:, :N_LINK]
        surfaces = np.minimum.reduceat(patches, self._first_patch)
        surfaces[list(self._surfaces).index(PORT_WALL), _SHAFTS] = np.inf
        return surfaces, arms.T

    def _surface_rows(
        self, cores: Callable[[int], Core], near: NDArray[np.bool_], moved_m: Array, first: int
    ) -> Iterator[tuple]:
        """Yield rows of `CORE_GAP`; the surfaces' obstacles count from `first`."""
        for k, surface in enumerate(self._surfaces.values()):
            surface.move(moved_m[k])
            for link in np.flatnonzero(near[k]).tolist():
                yield (
                    link,
                    first + k,
                    NO_LINK,
                    *_in_m(surface.gap(cores(link))),
                    0.0,
                    True,
                    NO_CAPSULE,
                )


def _rows_between_arms(
    cores: Callable[[int], Core], near: NDArray[np.bool_], radius_m: Array, obstacle: int
) -> Iterator[tuple]:
    """Yield rows of `CORE_GAP` for pairs of links of both arms."""
    for link, other in np.transpose(near.nonzero()).tolist():
        between = gap(cores(link), cores(N_LINK + other))
        yield link, obstacle, other, *_in_m(between), radius_m[N_LINK + other], True, NO_CAPSULE


def _in_m(gap: Gap) -> tuple[float, Array, Array]:
    return gap.distance_mm / MM, gap.a_mm / MM, gap.b_mm / MM


def _near_pairs(
    gaps: CoreGaps, links: LinkCores, names: tuple[str, ...], within_m: float, others_m: Array
) -> NearPairs:
    """Return the near pairs: the gaps between cores with the radii added."""
    radius_m = links.radius_m
    on_link, on_other = gaps["on_link_m"], gaps["on_other_m"]
    normal = (on_link - on_other) / gaps["apart_m"][:, None]
    arm, link = np.divmod(gaps["link"], N_LINK)
    return NearPairs(
        distance_m=_distance_m(gaps, radius_m),
        on_instrument_m=on_link - radius_m[gaps["link"], None] * normal,
        on_obstacle_m=on_other + gaps["other_radius_m"][:, None] * normal,
        normal=normal,
        arm=arm,
        link=link,
        other_link=gaps["other_link"],
        names=names,
        what=gaps["obstacle"],
        foremost=gaps["foremost"],
        capsule=gaps["capsule"],
        within_m=within_m,
        others_m=others_m,
        links=links,
    )


@cache
def _among(names: tuple[str, ...], wanted: tuple[str, ...]) -> NDArray[np.bool_]:
    """Return the mask (n,) of the wanted names."""
    return np.isin(names, wanted)


def _distance_m(gaps: CoreGaps, radius_m: Array) -> Array:
    """Return the distances (n,) between the surfaces, given the links' radii (8,)."""
    return gaps["apart_m"] - radius_m[gaps["link"]] - gaps["other_radius_m"]


def chain_gaps(links: LinkCores, chains: Capsules, within_m: float) -> CoreGaps:
    """Return the gaps of links and capsules nearer than `within_m`; `obstacle` counts chains."""
    radii_m = links.radius_m[:, None] + chains.radius_m
    apart_m, on_link, on_chain = segment_gaps(
        links, chains.start_m, chains.end_m, within_m + radii_m
    )
    touching = apart_m <= TOUCHING_MM / MM
    for k, capsule in np.argwhere(touching).tolist() if touching.any() else ():
        ends_m = np.stack([chains.start_m[capsule], chains.end_m[capsule]])
        found = overlap(links.core(k), Core(MM * ends_m))
        apart_m[k, capsule] = found.distance_mm / MM
        on_link[k, capsule], on_chain[k, capsule] = found.a_mm / MM, found.b_mm / MM
    distance_m = apart_m - radii_m
    nearest_m = np.minimum.reduceat(distance_m, chains.first, axis=1)
    pair = link, capsule = np.nonzero(distance_m < within_m)
    gaps = np.empty(len(link), CORE_GAP)
    gaps["link"], gaps["obstacle"], gaps["other_link"] = link, chains.chain[capsule], NO_LINK
    gaps["apart_m"], gaps["other_radius_m"] = apart_m[pair], chains.radius_m[capsule]
    gaps["on_link_m"], gaps["on_other_m"] = on_link[pair], on_chain[pair]
    gaps["capsule"] = capsule
    gaps["foremost"] = distance_m[pair] < nearest_m[link, gaps["obstacle"]] + ALONGSIDE_M
    return gaps
