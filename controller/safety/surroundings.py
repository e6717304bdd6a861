"""What the instruments must not hit, as a tracker and a registration would give it each step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from controller.safety.port_wall import port_wall
from controller.safety.rigid_surface import RigidSurface
from tissue_sim.frames import Array
from tissue_sim.jaws import GALLBLADDER
from tissue_sim.shapes import sheet
from tissue_sim.surroundings import (
    COMMON_DUCT_RADIUS_M,
    GRID_M,
    common_duct_line,
    liver_points,
    relief_rng,
)
from tissue_sim.sweep import Indices
from tissue_sim.world import World

LIVER, PORT_WALL = "liver", "port wall"
COMMON_DUCT = "common bile duct"


@dataclass(frozen=True, kw_only=True)
class CapsuleChain:
    """Capsules, world frame, m; neighbours need not touch: a severed tube is two chains.

    Attributes:
        start_m: (n, 3).
        end_m: (n, 3).
        radius_m: (n,).
    """

    start_m: Array
    end_m: Array
    radius_m: Array


@dataclass(frozen=True, kw_only=True)
class Capsules:
    """Of several chains, chain after chain, world frame, m.

    Attributes:
        names: of the chains.
        first: (n_chain,) first capsule of each chain.
        chain: (n,) whose each capsule is.
        start_m: (n, 3).
        end_m: (n, 3).
        radius_m: (n,).
    """

    names: tuple[str, ...]
    first: NDArray[np.integer]
    chain: NDArray[np.integer]
    start_m: Array
    end_m: Array
    radius_m: Array


@dataclass(frozen=True, kw_only=True)
class RigidSurroundings:
    """What keeps its shape for one patient, as registered once, the body at its place."""

    liver: RigidSurface
    port_wall: RigidSurface
    common_duct_m: Array  # (n, 3) centreline


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """What the instruments must not hit, where it is now.

    Attributes:
        moved_m: surface name -> (3,) how far it stands from where it was registered. The liver
            moves with the body, the port wall stays with the ports.
        chains: name -> what is round and soft: the common bile duct, the organ's tubes ("duct",
            "artery", and "second artery" where there is one; as wide as at rest) and the
            gallbladder, as wide as its rings are now.
    """

    moved_m: dict[str, Array]
    chains: dict[str, CapsuleChain]

    @cached_property
    def capsules(self) -> Capsules:
        """Of all chains."""
        chains = list(self.chains.values())
        lengths = [len(chain.radius_m) for chain in chains]
        whose = np.repeat(np.arange(len(chains)), lengths)
        return Capsules(
            names=tuple(self.chains),
            first=np.cumsum([0, *lengths[:-1]]),
            chain=whose,
            start_m=np.concatenate([chain.start_m for chain in chains]),
            end_m=np.concatenate([chain.end_m for chain in chains]),
            radius_m=np.concatenate([chain.radius_m for chain in chains]),
        )


def registered(world: World) -> RigidSurroundings:
    """Of the patient who lies there; as a registration before the operation would find it."""
    organ, anatomy = world.organ, world.anatomy
    liver = sheet(liver_points(organ, anatomy, relief_rng(anatomy)), GRID_M)
    return RigidSurroundings(
        liver=RigidSurface(points_m=liver.points.astype(float), triangles=liver.triangles),
        port_wall=port_wall(world.arms.T_world_rcm[:, :3, 3]),
        common_duct_m=common_duct_line(organ, anatomy),
    )


def surroundings_of(world: World, rigid: RigidSurroundings) -> Surroundings:
    """Where everything is now. Privileged: a tracker without error."""
    positions, offset = world.tissue.positions(), world.body.offset_m
    common_duct, sac = rigid.common_duct_m + offset, world.organ.sac_rings
    sac_radius_m = _mean_radius_m(positions, sac)
    chains = {
        COMMON_DUCT: chain_through(common_duct, COMMON_DUCT_RADIUS_M),
        GALLBLADDER: chain_through(
            positions[sac[:, 0]], 0.5 * (sac_radius_m[:-1] + sac_radius_m[1:])
        ),
    }
    for tube in world.organ.tubes:
        outside = slice(world.organ.neck_ring[tube] + 1)
        below, above = world.tubes.below[tube][outside, 0], world.tubes.above[tube][outside, 0]
        radius_m = world.tubes.radius_m(tube)
        chains[tube] = chain_through(positions[below], radius_m, positions[above])
    return Surroundings(moved_m={LIVER: offset, PORT_WALL: np.zeros(3)}, chains=chains)


def chain_through(
    points_m: NDArray[np.floating],
    radius_m: float | Array,
    upper_m: NDArray[np.floating] | None = None,
) -> CapsuleChain:
    """A capsule from each point (n, 3) to the next, as wide as given, alike or each (n - 1,).

    Where a tube is severed, `upper_m` (n, 3) holds the place of the point as the part above has
    it: a capsule goes from there to the next point.
    """
    start = points_m if upper_m is None else upper_m
    return CapsuleChain(
        start_m=start[:-1].astype(float),
        end_m=points_m[1:].astype(float),
        radius_m=np.full(len(points_m) - 1, radius_m),
    )


def _mean_radius_m(positions: NDArray[np.floating], rings: Indices) -> Array:
    """(n_ring,) the outer vertices' mean distance from the centre."""
    outer = positions[rings[:, (rings.shape[1] + 1) // 2 :]]
    spokes = outer - positions[rings[:, :1]]
    length = np.sqrt(np.einsum("rki,rki->rk", spokes, spokes))
    return length.sum(axis=1, dtype=float) / length.shape[1]
