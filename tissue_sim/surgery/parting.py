"""Split a tube at a ring: separate the faces of its section, wholly or in part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissue_sim.mechanics.topology import part_vertices
from tissue_sim.patient.mesher import section_triangles
from tissue_sim.patient.tubes import Tubes


@dataclass(frozen=True, kw_only=True)
class Opening:
    """An opening of a tube, made by a cut or a tear.

    Attributes:
        ring: the severed ring.
        station_m: station of that ring, along the tube at rest.
    """

    tube: str
    time_s: float
    ring: int
    station_m: float


def part_ring(
    tubes: Tubes,
    tube: str,
    ring: int,
    given_way: NDArray[np.bool_],
    *,
    station_m: float | None = None,
) -> bool:
    """Split the faces of a ring all of whose vertices have given way, and rewire the tissue.

    Args:
        tubes: The tubes of the tissue.
        tube: The tube's name.
        ring: A ring that is neither the fixed ring nor within the sac.
        given_way: (1 + 2 sectors,), whether each vertex of the ring has given way.
        station_m: Where the ring slides before it is split; None leaves it in place.

    Returns:
        False if nothing was split: no face has given way, or no spare vertex is left.
    """
    tissue, b, vertices = tubes.tissue, tubes.b, tubes.below[tube][ring]
    severed = {
        tuple(sorted(int(v) for v in vertices[face]))
        for face in section_triangles((len(vertices) - 1) // 2)
        if given_way[face].all()
    }
    n = tissue.n_vertex(b)
    tets, parents = part_vertices(tissue.tets(b), severed, vertices.tolist(), n)
    if not 0 < len(parents) <= tissue.spare_vertices(b):
        return False
    if station_m is not None:
        tubes.slide_ring(tube, ring, station_m)
    tissue.duplicate(b, parents)
    tissue.tets(b)[:] = tets
    for k, parent in enumerate(parents):
        tubes.above[tube][ring, np.flatnonzero(vertices == parent)[0]] = n + k
    around = tissue.host("ring_above")[b, tubes.organ.hollow.index(tube), ring]
    around[:] = tubes.above[tube][ring, -len(around) :]
    tissue.rewire(b)
    return True
