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

TRUNKS = {COMMON_DUCT: "common_bile_duct_m", HEPATIC_ARTERY: "hepatic_artery_m"}
FINE = 12  # capsules along a structure at risk
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
        line = trunk_line(
            getattr(observation, name), lines[BRANCHES[trunk]].points_m, RADIUS_M[trunk]
        )
        lines[trunk] = LineSeen(
            points_m=line,
            radius_m=RADIUS_M[trunk],
            std_m=np.full(len(line), observation.std_m[ROWS[name]].mean()),
        )
    return lines


def trunk_line(points: Array, branch: Array, radius_m: float) -> Array:
    """Return a smooth line (`FINE` + 1, 3) through points (4, 3) of a structure at risk.

    The line also passes under the branch's first point, which lies on the structure's wall: the
    branch may draw the structure out there. The line is a cubic spline over the chords' length. If
    all points are observed in one place, the line is that place.
    """
    along = unit(points[2] - points[1])
    leaves = branch[1] - branch[0]
    under = branch[0] - radius_m * unit(leaves - (leaves @ along) * along)
    kept = points[np.linalg.norm(points - under, axis=1) > BESIDE_M]
    if not len(kept):
        return np.repeat(under[None], len(_EVENLY), axis=0)
    whole = np.concatenate([kept, under[None]])
    whole = whole[np.argsort((whole - points[0]) @ (points[3] - points[0]))]
    chords = np.linalg.norm(whole[1:] - whole[:-1], axis=1)
    at = np.concatenate([[0.0], np.cumsum(chords)])
    return spline(at / at[-1], whole, _EVENLY)


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
    the gallbladder, and may be touched like the gallbladder. The longest piece of the line spans
    the cut: the stump takes half a usual piece.
    """
    start, end = line.points_m[:-1], line.points_m[1:]
    std_m = np.maximum(line.std_m[:-1], line.std_m[1:])
    radii_m = line.radius_m + np.minimum(UNSURE * std_m, MOST_M)
    if not line.severed:
        return start, end, radii_m
    cut = int(np.linalg.norm(end - start, axis=1).argmax())
    below = max(cut - 1, 0)
    stump_end = start[cut] + 0.5 * (end[below] - start[below])
    return start[: cut + 1], np.concatenate([end[:cut], stump_end[None]]), radii_m[: cut + 1]
