"""Place the structures at risk: the common bile duct, and the right hepatic artery.

The cystic duct branches off the common bile duct, and the cystic artery off the hepatic artery.
Traction on the gallbladder draws a branch out of its trunk's line ("tenting"). The apparent branch
is then the trunk: the classic injury (Strasberg et al., J. Am. Coll. Surg. 180, 1995).
"""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import AWAY, Array, field_point, unit

COMMON_DUCT = "common bile duct"
HEPATIC_ARTERY = "hepatic artery"
BRANCHES = {COMMON_DUCT: "duct", HEPATIC_ARTERY: "artery"}  # trunk -> the tube that branches off
AT_RISK = tuple(BRANCHES)

# assumed: outer radii of a common bile duct and a right hepatic artery
RADIUS_M = {COMMON_DUCT: 0.0030, HEPATIC_ARTERY: 0.0016}
SPACING_M = 0.005  # of a trunk's rings at most: jaws of a grasper have this width, and touch one
DIVE_M = 0.005  # assumed: depth below the branch at which the ends of a trunk leave the field
# assumed: both ends of a trunk from its branch, (towards the artery's side, up), m. The hepatic
# artery runs across its branch, so that no trunk passes between the jaws that clip the branch.
ENDS_M = {
    COMMON_DUCT: ((-0.021, 0.006), (0.006, -0.022)),
    HEPATIC_ARTERY: ((0.021, 0.006), (-0.006, -0.012)),
}
SAMPLES = 201  # points from which the rings are chosen; the middle point is at the branch


def course(trunk: str, branch: Array, side: float) -> Array:
    """Return the centreline of a trunk (n, 3), m, world frame.

    The centreline is a parabola through both ends whose wall touches the branch's first ring.

    Args:
        trunk: one of `AT_RISK`.
        branch: (m, 3), the branch's centreline from its trunk.
        side: 1 if the artery is on the right of the duct, else -1.
    """
    end = branch[0]
    first, last = (end + field_point(side * x, up, 0.0) + DIVE_M * AWAY for x, up in ENDS_M[trunk])
    tangent = unit(last - first)
    leaves = branch[1] - end
    across = unit(leaves - (leaves @ tangent) * tangent)
    t = np.linspace(-1.0, 1.0, SAMPLES)[:, None]
    line = end + 0.5 * t * (last - first) + t * t * (0.5 * (first + last) - end)
    return _ringed(line - RADIUS_M[trunk] * across)


def _ringed(line: Array) -> Array:
    """Return points (n_ring, 3), one in the line's middle and evenly spaced on either side."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    middle, end = arc[len(arc) // 2], arc[-1]
    before, after = (int(np.ceil(length / SPACING_M)) for length in (middle, end - middle))
    stations = np.append(
        np.linspace(0.0, middle, before, endpoint=False), np.linspace(middle, end, after + 1)
    )
    return np.stack([np.interp(stations, arc, line[:, k]) for k in range(3)], axis=1)
