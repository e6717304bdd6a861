"""Place the obstacles, from the observation alone: tubes and structures at risk as capsules."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controller.body_place import BodyPlace
from controller.safety.obstacles import LIVER, PORT_WALL, Surroundings, chained
from planner.scene.duct_side import structure_seen
from tissue_sim.frames import Array, transform, unit
from tissue_sim.patient.at_risk import BRANCHES, COMMON_DUCT, HEPATIC_ARTERY, RADIUS_M
from tissue_sim.sensing.observation import ROWS, TRUNK_POINTS, TUBE_ROWS, Observation
from tissue_sim.sensing.polyline import nearest_on, place_on

TRUNKS = {COMMON_DUCT: "common_bile_duct_m", HEPATIC_ARTERY: "hepatic_artery_m"}
FINE = 12  # capsules along a structure at risk
COVERED_M = 0.006  # from its branch a trunk is wholly covered: two jaws' widths; assumed
BESIDE_M = 0.003  # a point this near to the branch adds nothing to the line
UNSURE = 1.0  # standard deviations by which an uncertain structure is thicker
MOST_M = 0.0015  # by which a structure is thicker at most; assumed
_EVENLY = np.linspace(0.0, 1.0, FINE + 1)


class ObstaclesSeen:
    """Follows the obstacles of one patient through its observations."""

    def __init__(self) -> None:
        self._body = BodyPlace()

    def follow(self, observation: Observation) -> Surroundings:
        """Return the present places of the obstacles, world frame."""
        lines = lines_seen(observation)
        to_world = observation.T_world_endoscope
        pieces = [_capsules(line) for line in lines.values()]
        moved_m = {LIVER: self._moved_m(observation), PORT_WALL: np.zeros(3)}
        capsules = chained(
            dict(zip(lines, (len(radius_m) for *_, radius_m in pieces), strict=True)),
            start_m=transform(to_world, np.concatenate([start for start, _, _ in pieces])),
            end_m=transform(to_world, np.concatenate([end for _, end, _ in pieces])),
            radius_m=np.concatenate([radius_m for *_, radius_m in pieces]),
        )
        return Surroundings(moved_m=moved_m, capsules=capsules)

    def _moved_m(self, observation: Observation) -> Array:
        """Return the body's displacement (3,), from the fixed ends of the structures at risk."""
        ends = [
            points[k]
            for points in (getattr(observation, n) for n in TRUNKS.values())
            for k in (0, -1)
        ]
        rows = [k for n in TRUNKS.values() for k in (ROWS[n].start, ROWS[n].stop - 1)]
        std_m = float(np.linalg.norm(observation.std_m[rows])) / len(rows)
        middle = transform(observation.T_world_endoscope, np.mean(ends, axis=0)[None])[0]
        return self._body.follow(middle, std_m)


@dataclass(frozen=True, kw_only=True)
class LineSeen:
    """The centreline of a structure, endoscope frame.

    Attributes:
        points_m: (n, 3) points.
        radius_m: Outer radius.
        std_m: (n,) standard deviations of the points.
        severed: Whether the structure is in two parts.
    """

    points_m: Array
    radius_m: float
    std_m: Array
    severed: bool = False

    def parts_m(self) -> list[Array]:
        """Return the points (n, 3) of the parts: one, or the stump and what hangs beyond the cut.

        The longest piece of the line spans the cut: either part takes half a usual piece.
        """
        points, pieces = self.points_m, np.diff(self.points_m, axis=0)
        if not self.severed:
            return [points]
        cut = int(np.linalg.norm(pieces, axis=1).argmax())
        below, above = max(cut - 1, 0), min(cut + 1, len(pieces) - 1)
        stump_end = points[cut] + 0.5 * pieces[below]
        hanging_end = points[cut + 1] - 0.5 * pieces[above]
        return [
            np.concatenate([points[: cut + 1], stump_end[None]]),
            np.concatenate([hanging_end[None], points[cut + 1 :]]),
        ]


def lines_seen(observation: Observation) -> dict[str, LineSeen]:
    """Return the lines of the tubes that are there and of the structures at risk, by name."""
    lines = {}
    for tube in observation.tubes:
        lines[structure_seen(tube, observation)] = LineSeen(
            points_m=observation.tube_m(tube),
            radius_m=observation.radius_m(tube),
            std_m=observation.std_m[TUBE_ROWS[tube]],
            severed=observation.is_severed(tube),
        )
    for trunk, name in TRUNKS.items():
        branch = lines[BRANCHES[trunk]]
        line = trunk_line(getattr(observation, name), branch.points_m[0], RADIUS_M[trunk])
        lines[trunk] = LineSeen(
            points_m=line,
            radius_m=RADIUS_M[trunk],
            std_m=_trunk_std_m(
                line, RADIUS_M[trunk], float(observation.std_m[ROWS[name]].mean()), branch
            ),
        )
    return lines


def _trunk_std_m(line: Array, radius_m: float, covered_m: float, branch: LineSeen) -> Array:
    """Return standard deviations (n,) of a trunk's line (n, 3), of which most is covered.

    At its branch the trunk is dissected: there it is as uncertain as the branch's first point.
    """
    away_m = np.linalg.norm(line - branch.points_m[0], axis=1) - radius_m
    share = np.clip(away_m / COVERED_M, 0.0, 1.0)
    return branch.std_m[0] + share * max(covered_m - branch.std_m[0], 0.0)


def trunk_line(points: Array, root: Array, radius_m: float) -> Array:
    """Return a smooth line (`FINE` + 1, 3) through points (4, 3) of a structure at risk.

    The line also passes under the root (3,), its branch's first point, which lies on the wall: the
    branch may draw the structure out there. Of all places a radius from the root, the line passes
    through the one nearest to the line without it. The branch's direction is no measure of where
    the axis lies: a branch may lie along the structure.
    """
    without = _through(points)
    k, share, _ = nearest_on(without, root)
    under = root + radius_m * unit(place_on(without, k + share) - root)
    kept = points[np.linalg.norm(points - under, axis=1) > BESIDE_M]
    whole = np.concatenate([kept, under[None]])
    return _through(whole[np.argsort((whole - points[0]) @ (points[3] - points[0]))])


def _through(points: Array) -> Array:
    """Return a line (`FINE` + 1, 3) through points: a cubic spline over the chords' length.

    If all points are observed in one place, the line is that place.
    """
    chords = np.linalg.norm(points[1:] - points[:-1], axis=1)
    at = np.concatenate([[0.0], np.cumsum(chords)])
    if at[-1] < BESIDE_M:
        return np.repeat(points[:1], len(_EVENLY), axis=0)
    return spline(at / at[-1], points, _EVENLY)


def spline(at: Array, points: Array, wanted: Array) -> Array:
    """Return a cubic spline through points (n, 3), n at most 5, at the wanted parameters.

    The last point but one at either end is not a knot: of five points only the middle point is. For
    so few points this function takes a tenth of the time of SciPy's identical spline.
    """
    n = len(points)
    coefficients = np.linalg.solve(_powers(at, at, n), points)
    return _powers(wanted, at, n) @ coefficients


def _powers(t: Array, at: Array, n: int) -> Array:
    """Return the powers (len(t), n) of t, the fifth from the middle knot on."""
    powers = np.empty((n, len(t)))
    powers[0], powers[1:2], powers[2:3], powers[3:4] = 1.0, t, t * t, t * t * t
    if n == TRUNK_POINTS + 1:
        powers[4] = np.maximum(t - at[2], 0.0) ** 3
    return np.ascontiguousarray(powers.T)


def _capsules(line: LineSeen) -> tuple[Array, Array, Array]:
    """Return starts, ends and radii of capsules; uncertain capsules are thicker.

    Of a severed tube only the part that stays in the body is an obstacle. The other part hangs on
    the gallbladder, and may be touched like the gallbladder.
    """
    stays = line.parts_m()[0]
    std_m = np.maximum(line.std_m[:-1], line.std_m[1:])[: len(stays) - 1]
    return stays[:-1], stays[1:], line.radius_m + thicker_m(std_m)


def thicker_m(std_m: Array) -> Array:
    """Return by how much structures with standard deviations (n,) count as thicker (n,)."""
    return np.minimum(UNSURE * std_m, MOST_M)
