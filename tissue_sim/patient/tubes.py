"""Model all hollow structures in surgical terms: lines of rings with stations, lumen and stumps.

This tells which structures lie between an instrument's jaws.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_sim.frames import Array, inverse_pose, transform, unit
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.topology import components
from tissue_sim.patient.at_risk import BRANCHES
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import PARTS, Organ
from tissue_sim.tools.instruments import INSTRUMENTS

MEETING_HALF_GAP_M = 0.0016  # assumed: jaws this close to their middle plane meet
# A tube lies between closing jaws if its centreline is closer than this to their middle plane. A
# tube outside the jaws is farther away: by a finger (2 mm thick) and half the tube.
BETWEEN_HALF_GAP_M = 0.0025
TIP_EDGE_M = 2.0e-4  # assumed: closed jaws also hold tissue up to this distance beyond their tip
STRETCHED_SEGMENTS = 3  # assumed: a stretch is averaged over this number of segments, 5 mm
GALLBLADDER = "gallbladder"
# Gap at which the judge counts the gallbladder as clipped, and one step of closing. A finger is as
# thick: the wall may press on closing fingers from outside. Tissue between them moves inwards.
SAC_HALF_GAP_M = 0.0020


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """The point where a tube crosses the plane of an instrument's jaws.

    Attributes:
        station_m: Distance along the tube at rest, from its fixed end.
        ring: The nearest ring.
        tilt_rad: Angle between the tube and the normal of the jaws' plane, 0 to pi/2.
        point_m: Position in the tool frame.
    """

    tube: str
    station_m: float
    ring: int
    tilt_rad: float
    point_m: Array


class Tubes:
    """The hollow structures of one environment: the cystic tubes, and the trunks at risk.

    `above` contains the vertices of a severed ring's upper side.
    """

    def __init__(self, tissue: Tissue, organ: Organ, b: int = 0) -> None:
        self.tissue, self.organ, self.b = tissue, organ, b
        self.below = organ.rings
        self.above = {tube: rings.copy() for tube, rings in organ.rings.items()}
        self.stations_m = {tube: _stations(organ, tube) for tube in organ.hollow}
        self.length_m = {
            tube: float(s[organ.neck_ring[tube]]) for tube, s in self.stations_m.items()
        }
        self._rest_area = {tube: self._lumen_areas(organ.vertices, tube) for tube in organ.hollow}
        self.tie_rows = {
            tube: np.flatnonzero(np.isin(organ.tie_vertex, organ.rings[tube][1:]))
            for tube in organ.tubes
        }
        self.root_rows = {
            trunk: np.flatnonzero(np.isin(organ.tie_vertex, organ.rings[branch][0]))
            for trunk, branch in BRANCHES.items()
            if branch in organ.rings
        }
        n = (next(iter(self.below.values())).shape[1] - 1) // 2
        self._inner = slice(1, 1 + n)
        sections = [self.below[tube][: organ.neck_ring[tube] + 1] for tube in organ.hollow]
        self._n_centre = [len(rings) for rings in sections]
        self._section = np.concatenate(sections)
        self._centre = self._section[:, 0].copy()
        shift = np.roll(np.eye(n), 1, axis=1)  # x @ shift @ x.T sums x_k x_(k+1)
        self._next = shift - shift.T
        self._vertices: dict[str, tuple[bytes, Indices]] = {}  # by the rings above a tube's cuts
        self._tube_tets = {
            tube: np.flatnonzero(organ.region // 2 == PARTS.index(tube)) for tube in organ.hollow
        }

    def centres(self, tube: str) -> Array:
        """Return the (n_ring, 3) centreline up to the neck, world frame, m."""
        rings = self.below[tube][: self.organ.neck_ring[tube] + 1, 0]
        return self.tissue.positions(self.b)[rings].astype(np.float64)

    def stretches(self) -> dict[str, float]:
        """Return the largest stretch of each tube's centreline, for tubes that are not severed.

        The stretch is averaged over a few segments, because jaws also move single rings. Segments
        under clips are left out: tissue squeezed out by a clip lengthens them by up to a half,
        without any pull.
        """
        centres = self.tissue.positions(self.b).take(self._centre, axis=0).astype(np.float64)
        steps = centres[1:] - centres[:-1]
        lines = list(zip(self.organ.hollow, self._n_centre, strict=True))
        stations = np.concatenate([self.stations_m[tube][:n] for tube, n in lines])
        now_m, rest_m = np.sqrt(np.vecdot(steps, steps)), stations[1:] - stations[:-1]
        covered = self.tissue.host("covered")[self.b]
        under = covered.take(self._section).any(axis=1) if covered.any() else None
        found, start = {}, 0
        for tube, n in lines:
            segments = slice(start, start + n - 1)
            now, rest = now_m[segments], rest_m[segments]
            if under is not None:
                clipped = under[start : start + n]
                free = ~(clipped[:-1] | clipped[1:])
                now, rest = now[free], rest[free]
            found[tube] = _largest_share(now, rest)
            start += n
        return found

    def torn_share(self, trunk: str) -> float:
        """Return the torn share of the joint between a trunk and its branch, 0 to 1."""
        rows = self.root_rows.get(trunk, ())
        torn = self.tissue.host("tie_stiffness")[self.b, rows] == 0.0
        return float(torn.mean()) if len(torn) else 0.0

    def root_m(self, trunk: str) -> Array:
        """Return the middle (3,) of the place where a trunk's branch leaves it, world frame."""
        rows = self.root_rows[trunk]
        corners = self.tissue.host("tie_corner")[self.b, rows, 1:]
        weights = -self.tissue.host("tie_weight")[self.b, rows, 1:]
        x = self.tissue.positions(self.b)[corners].astype(float)
        return (weights[..., None] * x).sum(axis=1).mean(axis=0)

    def vertices(self, tube: str) -> Indices:
        """Return the vertices of a tube up to the neck, on both sides of its cuts."""
        above = self.above[tube].tobytes()
        if self._vertices.get(tube, (b"",))[0] != above:
            rings = slice(self.organ.neck_ring[tube] + 1)
            both = np.concatenate(
                [self.below[tube][rings].ravel(), self.above[tube][rings].ravel()]
            )
            self._vertices[tube] = above, np.unique(both).astype(np.int32)
        return self._vertices[tube][1]

    def radius_m(self, tube: str) -> float:
        """Return the outer radius at rest."""
        return float(self.tissue.host("tube_radius")[self.b, self.organ.hollow.index(tube)])

    def point(self, tube: str, station_m: float) -> tuple[Array, Array]:
        """Return position (3,) and unit tangent (3,) at a station, on its stump, world frame."""
        centres, stations = self.centres(tube), self.stations_m[tube]
        first, last = self.stump(tube, station_m)
        centres[first] = self.tissue.positions(self.b)[self.above[tube][first, 0]]
        k = int(np.clip(np.searchsorted(stations, station_m) - 1, first, last - 1))
        t = (station_m - stations[k]) / (stations[k + 1] - stations[k])
        low, high = max(k - 1, first), min(k + 2, last)
        return centres[k] + t * (centres[k + 1] - centres[k]), unit(centres[high] - centres[low])

    def ring_spacing_m(self, tube: str) -> float:
        """Return the mean distance between rings at rest."""
        return self.length_m[tube] / self.organ.neck_ring[tube]

    def side(self, tube: str, station_m: float) -> Indices:
        """Return the (n_ring, 1 + 2 n) rings of the stump at a station."""
        upper = self.stations_m[tube] < station_m
        return np.where(upper[:, None], self.above[tube], self.below[tube])

    def stump(self, tube: str, station_m: float) -> tuple[int, int]:
        """Return the first and last ring of the part of the tube that contains a station."""
        severed, stations = self.severed_rings(tube), self.stations_m[tube]
        upper = stations[severed] < station_m
        return (
            int(max(severed[upper], default=0)),
            int(min(severed[~upper], default=self.organ.neck_ring[tube])),
        )

    def free_ends_m(self, tube: str) -> Array:
        """Return the stations (n,) where the tube is severed."""
        return self.stations_m[tube][self.severed_rings(tube)]

    def lumen_fraction_at(self, tube: str, ring: int, station_m: float) -> float:
        """Return the area of a ring's lumen over the area at rest, on the stump at a station."""
        rings = self.above if self.stations_m[tube][ring] < station_m else self.below
        corners = self.tissue.positions(self.b)[rings[tube][ring, self._inner]].astype(np.float64)
        turn = corners.T @ self._next @ corners  # twice the area's vector, as a skew matrix
        twice = np.sqrt(turn[0, 1] ** 2 + turn[1, 2] ** 2 + turn[2, 0] ** 2)
        return float(0.5 * twice / self._rest_area[tube][ring])

    def rest_lumen_m2(self, tube: str) -> Array:
        """Return the (n_ring,) area of the lumen at rest."""
        return self._rest_area[tube]

    def open_share(self, tube: str, ring: int) -> float:
        """Return the share of the lumen's edge that is severed at a ring, 0 to 1."""
        inner = slice(1, 1 + (self.below[tube].shape[1] - 1) // 2)
        return float((self.above[tube] != self.below[tube])[ring, inner].mean())

    def crossing(
        self,
        tube: str,
        T_world_tool: Array,
        reach_m: float,
        half_gap_m: float = BETWEEN_HALF_GAP_M,
    ) -> Crossing | None:
        """Return where the tube crosses the plane x = 0 between an instrument's jaws.

        Each segment of the centreline lies on its own stump, up to the very ends of the stump.

        Args:
            tube: Name of the tube.
            T_world_tool: (4, 4) pose of the tool.
            reach_m: Length, back from the tip, over which the jaws act.
            half_gap_m: Largest distance from the jaws' middle plane. The default is for closing
                jaws.
        """
        neck, x = self.organ.neck_ring[tube], self.tissue.positions(self.b)
        rings = np.stack([self.above[tube][:neck, 0], self.below[tube][1 : neck + 1, 0]])
        start, end = transform(inverse_pose(T_world_tool), x[rings].astype(np.float64))
        spans = (start[:, 0] * end[:, 0] <= 0) & (start[:, 0] != end[:, 0])
        best = None
        for k in np.flatnonzero(spans).tolist():
            t = start[k, 0] / (start[k, 0] - end[k, 0])
            point = start[k] + t * (end[k] - start[k])
            if not -reach_m <= point[2] <= self.radius_m(tube):
                continue
            if abs(point[1]) < half_gap_m and (
                best is None or abs(point[1]) < abs(best.point_m[1])
            ):
                s = self.stations_m[tube]
                station_m = float(s[k] + t * (s[k + 1] - s[k]))
                first, last = self.stump(tube, station_m)
                tangent = unit(end[min(k + 1, last - 1)] - start[max(k - 1, first)])
                best = Crossing(
                    tube=tube,
                    station_m=station_m,
                    ring=k + round(float(t)),
                    tilt_rad=float(np.arccos(np.clip(abs(tangent[0]), 0.0, 1.0))),
                    point_m=point,
                )
        return best

    def nearest(self, T_world_tool: Array, reach_m: float) -> str:
        """Return the tube nearest to the middle of jaws that act from the tip back to `reach_m`."""
        middle = T_world_tool[:3, 3] - 0.5 * reach_m * T_world_tool[:3, 2]
        return min(
            self.organ.tubes, key=lambda t: np.linalg.norm(self.centres(t) - middle, axis=1).min()
        )

    def sac_between(
        self,
        T_world_tool: Array,
        reach_m: float,
        width_m: float,
        half_gap_m: float = MEETING_HALF_GAP_M,
    ) -> bool:
        """Return whether part of the gallbladder lies where the closing jaws meet.

        Args:
            T_world_tool: (4, 4) pose of the tool.
            reach_m: Length, back from the tip, over which the jaws act.
            width_m: Width of the jaws, along x.
            half_gap_m: Largest distance from the jaws' middle plane.
        """
        sac = self.tissue.positions(self.b)[self.organ.sac_rings.ravel()].astype(float)
        x, y, z = transform(inverse_pose(T_world_tool), sac).T
        across = (np.abs(x) < 0.5 * width_m) & (np.abs(y) < half_gap_m)
        return bool((across & (-reach_m < z) & (z < 0.0)).any())

    def slide_ring(self, tube: str, ring: int, station_m: float) -> None:
        """Move a ring of the mesh along the tube, both at rest and at its current position.

        The ring slides on the straight edges to its neighbour. So the shape stays the same, and a
        cut lies at the blades and not at the nearest ring.
        """
        there, share = self._way(tube, ring, station_m)
        below, above = self.below[tube][ring], self.above[tube][ring]
        split = above != below  # by an earlier cut, in part
        here = np.concatenate([below, above[split]])
        self.tissue.slide(self.b, here, np.concatenate([there, there[split]]), share)
        self.stations_m[tube][ring] = station_m

    def slid_ring_m(self, tube: str, ring: int, station_m: float) -> Array:
        """Return the positions (1 + 2 n, 3) that `slide_ring` would give a ring, world frame."""
        x = self.tissue.positions(self.b).astype(np.float64)
        (there, share), here = self._way(tube, ring, station_m), self.below[tube][ring]
        return x[here] + share * (x[there] - x[here])

    def _way(self, tube: str, ring: int, station_m: float) -> tuple[Indices, float]:
        """Return the neighbour towards which a ring slides, on its stump, and the share of it."""
        stations = self.stations_m[tube]
        neighbour = ring + 1 if station_m > stations[ring] else ring - 1
        share = (station_m - stations[ring]) / (stations[neighbour] - stations[ring])
        return self.side(tube, station_m)[neighbour], float(share)

    def severed_rings(self, tube: str) -> Indices:
        """Return the rings whose two sides share no vertex."""
        apart = (self.above[tube] != self.below[tube]).all(axis=1)
        return np.flatnonzero(apart).astype(np.int32)

    def in_two_parts(self, tube: str) -> bool:
        """Return whether no element joins the fixed end to the sac's end."""
        tets = self.tissue.tets(self.b)[self._tube_tets[tube]]
        label = components(self.tissue.n_vertex(self.b), tets)
        return label[self.below[tube][0, 0]] != label[self.above[tube][-1, 0]]

    def _lumen_areas(self, positions: Array, tube: str) -> Array:
        """Return the (n_ring,) area of the inner ring's polygon, m^2."""
        rings = self.below[tube]
        n = (rings.shape[1] - 1) // 2
        corners = positions[rings[:, 1 : 1 + n]].astype(np.float64)
        spokes = corners - corners.mean(axis=1, keepdims=True)
        areas = 0.5 * np.cross(spokes, np.roll(spokes, -1, axis=1)).sum(axis=1)
        return np.linalg.norm(areas, axis=1)


def _largest_share(now_m: Array, rest_m: Array) -> float:
    """Return the largest ratio of now to rest, each averaged over neighbouring segments (n,)."""
    if not len(now_m):
        return 1.0
    window = np.ones(min(STRETCHED_SEGMENTS, len(now_m)))
    return float((np.convolve(now_m, window, "valid") / np.convolve(rest_m, window, "valid")).max())


def _stations(organ: Organ, tube: str) -> Array:
    centres = organ.vertices[organ.rings[tube][:, 0]]
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(centres, axis=0), axis=1))])


def between_jaws(tubes: Tubes, T_world_tool: Array, tool: str) -> frozenset[str]:
    """Return the names of the structures that the jaws would close on.

    The margin is wide enough for one step of motion before the jaws close.
    """
    reach_m, width_m = INSTRUMENTS[tool].mouth_m
    found = {t for t in tubes.organ.hollow if tubes.crossing(t, T_world_tool, reach_m)}
    if tubes.sac_between(T_world_tool, reach_m, width_m, SAC_HALF_GAP_M):
        found.add(GALLBLADDER)
    return frozenset(found)
