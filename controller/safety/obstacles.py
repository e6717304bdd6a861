"""Define the instruments' obstacles: those registered once, and the present places of all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from controller.safety.geometry.rigid_surface import RigidSurface, port_wall
from tissue_sim.frames import Array
from tissue_sim.patient.assistant import SHAFT_RADIUS_M, assistant_of
from tissue_sim.patient.mesher import Indices, ring_radii_m
from tissue_sim.patient.surroundings import GRID_M, liver_points, relief_rng
from tissue_sim.patient.tubes import GALLBLADDER
from tissue_sim.rendering.shapes import sheet

if TYPE_CHECKING:
    from tissue_sim.world import World

LIVER, PORT_WALL, ASSISTANT = "liver", "port wall", "assistant's grasper"
MARGIN_M = 0.0005  # kept from obstacles; assumed: more than the arms give way and lag
TUBE_MARGIN_M = 0.001  # the same of a cystic tube, which moves by itself; assumed


@dataclass(frozen=True, kw_only=True)
class Capsules:
    """The capsules of several chains, chain after chain, world frame, m.

    Neighbours in a chain need not touch: a tube may be severed.

    Attributes:
        names: Names of the chains.
        first: (n_chain,) first capsule of each chain.
        chain: (n,) chain of each capsule.
        start_m: (n, 3) starts of the capsules' axes.
        end_m: (n, 3) ends of the capsules' axes.
        radius_m: (n,) radii.
    """

    names: tuple[str, ...]
    first: Indices
    chain: Indices
    start_m: Array
    end_m: Array
    radius_m: Array

    def of(self, name: str) -> NDArray[np.bool_]:
        """Return the mask (n,) of the capsules of this chain."""
        return self.chain == self.names.index(name)


def chained(lengths: Mapping[str, int], start_m: Array, end_m: Array, radius_m: Array) -> Capsules:
    """Return capsules (n, 3), (n, 3), (n,) of chains with the given lengths, by their names."""
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
    """What keeps its shape in one patient, registered once with the body at rest.

    Attributes:
        liver: Surface of the liver.
        port_wall: Surface around the arms' ports.
        assistant_m: (2, 3) tips of the assistant's grasper, and its port.
    """

    liver: RigidSurface
    port_wall: RigidSurface
    assistant_m: Array


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """The present places of all obstacles.

    Attributes:
        moved_m: Surface name to the displacement (3,) since the registration. Liver and
            assistant's grasper move with the body, the port wall stays with the ports.
        capsules: Capsules of the round and soft structures. The gallbladder has its present width.
            Hollow structures (`Organ.hollow`: cystic tubes and structures at risk) have their width
            at rest.
    """

    moved_m: dict[str, Array]
    capsules: Capsules


def registered(world: World) -> RigidSurroundings:
    """Return the rigid surroundings, as a registration before the operation would find them."""
    organ, anatomy = world.organ, world.anatomy
    assistant = assistant_of(organ)
    liver = sheet(liver_points(organ, anatomy, relief_rng(anatomy)), GRID_M)
    return RigidSurroundings(
        liver=RigidSurface(points_m=liver.points.astype(float), triangles=liver.triangles),
        port_wall=port_wall(world.arms.T_world_rcm[:, :3, 3]),
        assistant_m=np.stack([assistant.tip_m, assistant.port_m]),
    )


def with_assistant(around: Surroundings, assistant_m: Array) -> Capsules:
    """Return the capsules with one more chain, `ASSISTANT`, at its present place."""
    capsules = around.capsules
    lengths = np.bincount(capsules.chain, minlength=len(capsules.names))
    start_m, end_m = assistant_m[:, None] + around.moved_m[LIVER]
    return chained(
        {**dict(zip(capsules.names, lengths.tolist(), strict=True)), ASSISTANT: 1},
        start_m=np.concatenate([capsules.start_m, start_m]),
        end_m=np.concatenate([capsules.end_m, end_m]),
        radius_m=np.append(capsules.radius_m, SHAFT_RADIUS_M),
    )


def surroundings_of(world: World) -> Surroundings:
    """Return the present surroundings. Privileged: the exact state of the simulation."""
    positions, sac = world.tissue.positions(), world.organ.sac_rings
    starts, ends, sac_m = [sac[:-1, 0]], [sac[1:, 0]], ring_radii_m(positions, sac)
    radii_m = [0.5 * (sac_m[:-1] + sac_m[1:])]
    for tube in world.organ.hollow:
        neck = world.organ.neck_ring[tube]
        starts.append(world.tubes.above[tube][:neck, 0])
        ends.append(world.tubes.below[tube][1 : neck + 1, 0])
        radii_m.append(np.full(neck, world.tubes.radius_m(tube)))
    names = GALLBLADDER, *world.organ.hollow
    capsules = chained(
        dict(zip(names, map(len, radii_m), strict=True)),
        start_m=positions[np.concatenate(starts)].astype(float),
        end_m=positions[np.concatenate(ends)].astype(float),
        radius_m=np.concatenate(radii_m),
    )
    moved_m = {LIVER: world.body.offset_m, PORT_WALL: np.zeros(3)}
    return Surroundings(moved_m=moved_m, capsules=capsules)
