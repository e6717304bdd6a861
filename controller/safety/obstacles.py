"""The obstacles of the instruments, as a tracker and a registration would give them each step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from controller.safety.geometry.port_wall import port_wall
from controller.safety.geometry.rigid_surface import RigidSurface
from tissue_sim.frames import Array
from tissue_sim.outcome.jaws import GALLBLADDER
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.surroundings import (
    COMMON_DUCT_RADIUS_M,
    GRID_M,
    common_duct_line,
    liver_points,
    relief_rng,
)
from tissue_sim.rendering.shapes import sheet
from tissue_sim.world import World

LIVER, PORT_WALL = "liver", "port wall"
COMMON_DUCT = "common bile duct"


@dataclass(frozen=True, kw_only=True)
class Capsules:
    """The capsules of several chains, chain after chain, world frame, m.

    Neighbours in a chain need not touch: a tube may be severed.

    Attributes:
        names: of the chains.
        first: (n_chain,) first capsule of each chain.
        chain: (n,) chain of each capsule.
        start_m: (n, 3).
        end_m: (n, 3).
        radius_m: (n,).
    """

    names: tuple[str, ...]
    first: Indices
    chain: Indices
    start_m: Array
    end_m: Array
    radius_m: Array

    def of(self, name: str) -> NDArray[np.bool_]:
        """Return (n,) which capsules belong to this chain."""
        return self.chain == self.names.index(name)


def chained(lengths: Mapping[str, int], start_m: Array, end_m: Array, radius_m: Array) -> Capsules:
    """Make capsules (n, 3), (n, 3), (n,) of chains with the given lengths, by their names."""
    first, chain = _places(tuple(lengths.values()))
    return Capsules(
        names=tuple(lengths),
        first=first,
        chain=chain,
        start_m=start_m,
        end_m=end_m,
        radius_m=radius_m,
    )


@cache
def _places(lengths: tuple[int, ...]) -> tuple[Indices, Indices]:
    """Return the first capsule (n_chain,) of each chain, and the chain (n,) of each capsule."""
    first, chain = np.cumsum([0, *lengths[:-1]]), np.repeat(np.arange(len(lengths)), lengths)
    return first.astype(np.int32), chain.astype(np.int32)


@dataclass(frozen=True, kw_only=True)
class RigidSurroundings:
    """What keeps its shape in one patient, as registered once, with the body at rest."""

    liver: RigidSurface
    port_wall: RigidSurface
    common_duct_m: Array  # (n, 3) centreline


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """The present places of all obstacles.

    Attributes:
        moved_m: surface name -> (3,) how far it has moved since its registration. The liver moves
            with the body, the port wall stays with the ports.
        capsules: what is round and soft: the common bile duct, the gallbladder with its present
            width, and the organ's tubes ("duct", "artery", and "second artery" if there is one)
            with their width at rest.
    """

    moved_m: dict[str, Array]
    capsules: Capsules


def registered(world: World) -> RigidSurroundings:
    """Return the rigid surroundings, as a registration before the operation would find them."""
    organ, anatomy = world.organ, world.anatomy
    liver = sheet(liver_points(organ, anatomy, relief_rng(anatomy)), GRID_M)
    return RigidSurroundings(
        liver=RigidSurface(points_m=liver.points.astype(float), triangles=liver.triangles),
        port_wall=port_wall(world.arms.T_world_rcm[:, :3, 3]),
        common_duct_m=common_duct_line(organ, anatomy),
    )


def surroundings_of(world: World, rigid: RigidSurroundings) -> Surroundings:
    """Return the present surroundings. Privileged: the exact state of the simulation."""
    positions, offset = world.tissue.positions(), world.body.offset_m
    common_duct, sac = rigid.common_duct_m + offset, world.organ.sac_rings
    starts, ends, sac_m = [sac[:-1, 0]], [sac[1:, 0]], _mean_radius_m(positions, sac)
    radii_m = [np.full(len(common_duct) - 1, COMMON_DUCT_RADIUS_M), 0.5 * (sac_m[:-1] + sac_m[1:])]
    for tube in world.organ.tubes:
        neck = world.organ.neck_ring[tube]
        starts.append(world.tubes.above[tube][:neck, 0])
        ends.append(world.tubes.below[tube][1 : neck + 1, 0])
        radii_m.append(np.full(neck, world.tubes.radius_m(tube)))
    names = COMMON_DUCT, GALLBLADDER, *world.organ.tubes
    capsules = chained(
        dict(zip(names, map(len, radii_m), strict=True)),
        start_m=np.concatenate([common_duct[:-1], positions[np.concatenate(starts)]]),
        end_m=np.concatenate([common_duct[1:], positions[np.concatenate(ends)]]),
        radius_m=np.concatenate(radii_m),
    )
    return Surroundings(moved_m={LIVER: offset, PORT_WALL: np.zeros(3)}, capsules=capsules)


def _mean_radius_m(positions: NDArray[np.floating], rings: Indices) -> Array:
    """Return (n_ring,) the outer vertices' mean distance from the centre."""
    outer = positions[rings[:, (rings.shape[1] + 1) // 2 :]]
    spokes = outer - positions[rings[:, :1]]
    return np.sqrt(np.vecdot(spokes, spokes)).mean(axis=1, dtype=float)
