"""Scissors: sever the faces between the blades, so that the tube falls into two parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.sweep import Indices
from tissue_sim.topology import part_vertices
from tissue_sim.tubes import Crossing, Tubes

BLADE_LENGTH_M = 0.011  # curved scissors, assumed
BLADE_WIDTH_M = 0.0010  # thickness of the closed blades, assumed
SHEAR_GAP_M = 0.0012  # blades' distance at the tissue at which it parts, assumed


@dataclass(frozen=True, kw_only=True)
class Cut:
    """One closing of the blades through a tube.

    Attributes:
        station_m: of the severed ring, along the tube at rest.
        whole: the tube was severed over its whole width.
    """

    tube: str
    time_s: float
    ring: int
    station_m: float
    whole: bool


def sever(tubes: Tubes, T_world_tool: Array, *, time_s: float) -> tuple[Cut, ...]:
    """Cut every tube between the closed blades. The tissue is rewired."""
    cuts = []
    for tube in tubes.organ.tubes:
        crossing = tubes.crossing(tube, T_world_tool, BLADE_LENGTH_M)
        if crossing is not None and _part(tubes, crossing, T_world_tool):
            whole = bool(crossing.ring in tubes.severed_rings(tube))
            station = float(tubes.stations_m[tube][crossing.ring])
            cuts.append(
                Cut(tube=tube, time_s=time_s, ring=crossing.ring, station_m=station, whole=whole)
            )
    return tuple(cuts)


def _part(tubes: Tubes, crossing: Crossing, T_world_tool: Array) -> bool:
    """Split the ring's faces under the blades; False when nothing gave way."""
    tube, r = crossing.tube, crossing.ring
    if not 0 < r < tubes.organ.neck_ring[tube]:
        return False
    tubes.slide_ring(tube, r, crossing.station_m)
    tissue, b, ring = tubes.tissue, tubes.b, tubes.below[crossing.tube][r]
    local = transform(inverse_pose(T_world_tool), tissue.positions(b)[ring].astype(float))
    under = (local[:, 2] > -BLADE_LENGTH_M) & (local[:, 2] < 2.0e-4)
    severed = {
        tuple(sorted(int(v) for v in ring[face]))
        for face in ring_faces(len(ring))
        if under[face].all()
    }
    n = tissue.n_vertex(b)
    tets, parents = part_vertices(tissue.tets(b), severed, ring.tolist(), n)
    if not parents:
        return False
    tissue.duplicate(b, parents)
    tissue.tets(b)[:] = tets
    for k, parent in enumerate(parents):
        tubes.above[tube][r, np.flatnonzero(ring == parent)[0]] = n + k
    if r in tubes.severed_rings(tube):
        tissue.host("ring_joined")[b, tubes.organ.tubes.index(tube), r] = 0
    tissue.rewire(b)
    return True


def ring_faces(n_ring: int) -> Indices:
    """Triangles (n, 3) of a section, as places within a ring: centre, inner, outer."""
    n = (n_ring - 1) // 2
    k = np.arange(n)
    inner, inner_next = 1 + k, 1 + (k + 1) % n
    outer, outer_next = inner + n, inner_next + n
    return np.concatenate(
        [
            np.stack([np.zeros_like(k), inner, inner_next], axis=1),
            np.stack([inner, outer, outer_next], axis=1),
            np.stack([inner, outer_next, inner_next], axis=1),
        ]
    ).astype(np.int32)
