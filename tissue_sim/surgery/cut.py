"""Cut with scissors: sever the faces between the blades, so that the tube separates in two."""

from __future__ import annotations

from dataclasses import dataclass

from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.patient.tubes import TIP_EDGE_M, Crossing, Tubes
from tissue_sim.surgery.parting import Opening, part_ring
from tissue_sim.tools.instruments import BLADE_LENGTH_M

SHEAR_GAP_M = 0.0012  # assumed: distance of the blades at which tissue is cut
THINNEST_M = 3.0e-4  # assumed: a slice that a cut leaves; thinner elements would not stay sound


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
        place = None if crossing is None else _place(tubes, crossing)
        if place is not None and _part(tubes, tube, place, T_world_tool):
            ring, station = place
            whole = bool(ring in tubes.severed_rings(tube))
            cuts.append(Cut(tube=tube, time_s=time_s, ring=ring, station_m=station, whole=whole))
    return tuple(cuts)


def _place(tubes: Tubes, crossing: Crossing) -> tuple[int, float] | None:
    """Return the ring to split and the station to which it slides.

    The ring is the nearest one inside of the stump, so blades at the very end of a tube cut, too.
    A piece of one segment has no such ring, and is not cut.
    """
    tube, stations = crossing.tube, tubes.stations_m[crossing.tube]
    first, last = tubes.stump(tube, crossing.station_m)
    if last - first < 2:
        return None
    ring = min(max(crossing.ring, first + 1), last - 1)
    lowest, highest = stations[first] + THINNEST_M, stations[last] - THINNEST_M
    return ring, float(min(max(crossing.station_m, lowest), highest))


def _part(tubes: Tubes, tube: str, place: tuple[int, float], T_world_tool: Array) -> bool:
    """Split the ring's faces under the blades; return False if nothing was split or moved."""
    ring, station_m = place
    z = transform(inverse_pose(T_world_tool), tubes.slid_ring_m(tube, ring, station_m))[:, 2]
    given_way = (z > -BLADE_LENGTH_M) & (z < TIP_EDGE_M)
    return part_ring(tubes, tube, ring, given_way, station_m=station_m)
