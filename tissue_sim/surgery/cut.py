"""Cut with scissors: sever the faces between the blades, so that the tube separates in two."""

from __future__ import annotations

from dataclasses import dataclass

from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.patient.tubes import TIP_EDGE_M, Crossing, Tubes
from tissue_sim.surgery.parting import Opening, part_ring
from tissue_sim.tools.instruments import BLADE_LENGTH_M

SHEAR_GAP_M = 0.0012  # assumed: distance of the blades at which tissue is cut


@dataclass(frozen=True, kw_only=True)
class Cut(Opening):
    """One closing of the blades through a tube.

    Attributes:
        whole: whether the tube was severed over its whole width.
    """

    whole: bool


def sever(tubes: Tubes, T_world_tool: Array, *, time_s: float) -> tuple[Cut, ...]:
    """Cut every tube between the closed blades and rewire the tissue."""
    cuts = []
    for tube in tubes.organ.hollow:
        crossing = tubes.crossing(tube, T_world_tool, BLADE_LENGTH_M)
        if crossing is not None and _part(tubes, crossing, T_world_tool):
            whole = bool(crossing.ring in tubes.severed_rings(tube))
            station = float(tubes.stations_m[tube][crossing.ring])
            cuts.append(
                Cut(tube=tube, time_s=time_s, ring=crossing.ring, station_m=station, whole=whole)
            )
    return tuple(cuts)


def _part(tubes: Tubes, crossing: Crossing, T_world_tool: Array) -> bool:
    """Split the ring's faces under the blades; return False if nothing was split."""
    tube, r = crossing.tube, crossing.ring
    if not 0 < r < tubes.organ.neck_ring[tube]:
        return False
    tubes.slide_ring(tube, r, crossing.station_m)
    ring = tubes.tissue.positions(tubes.b)[tubes.below[tube][r]].astype(float)
    z = transform(inverse_pose(T_world_tool), ring)[:, 2]
    return part_ring(tubes, tube, r, (z > -BLADE_LENGTH_M) & (z < TIP_EDGE_M))
