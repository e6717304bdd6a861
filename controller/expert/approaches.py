"""List the approaches of the right tool to its place on a tube, in the order of their trial."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from controller.expert.motion import CLEARANCE_M, OFF_CENTRE_M

NARROW_M, NARROW_OFF_M = 0.0010, 0.0007  # clearance and offset of jaws in narrow places; assumed


@dataclass(frozen=True, kw_only=True)
class Approach:
    """How the right tool approaches its place on a tube.

    Attributes:
        turn_rad: Angle from straight ahead, towards the left.
        aside: Shift of the place from 0, the usual place, to 2, as far down from the gallbladder as
            clips and cuff allow.
        off_centre_m: Offset of the jaws' middle from the tube, along the tool's y.
        by_tip: Whether the tip barely reaches over the tube, and so spares what lies behind it.
        clearance_m: Distance of the tube from either open finger, for a tube in the middle.
        tilt_rad: Angle of the jaws from square across the tube, about the tool's y.
    """

    turn_rad: float = 0.0
    aside: float = 0.0
    off_centre_m: float = 0.0
    by_tip: bool = False
    clearance_m: float = CLEARANCE_M
    tilt_rad: float = 0.0

    def opening_rad(self, usual_rad: float, radius_m: float) -> float:
        """Return the jaws' opening for a tube of this radius, given the usual opening."""
        return usual_rad * (radius_m + self.clearance_m) / (radius_m + CLEARANCE_M)

    def closing(self, open_share: float, radius_m: float) -> Approach:
        """Return the approach of half closed jaws, which come to the tube from both sides at once.

        Args:
            open_share: Opening of the jaws over their opening at the start.
            radius_m: Radius of the tube.
        """
        beside_m = (radius_m + self.clearance_m) * open_share - radius_m
        most_m = float(np.clip(beside_m - self.clearance_m + abs(self.off_centre_m), 0.0, np.inf))
        return replace(self, off_centre_m=float(np.clip(self.off_centre_m, -most_m, most_m)))


USUAL = Approach()
APPROACHES = tuple(  # tried in this order, the usual one first
    Approach(
        turn_rad=turn,
        aside=aside,
        off_centre_m=side * off_m,
        by_tip=by_tip,
        clearance_m=clearance_m,
    )
    for by_tip in (False, True)
    for aside in (0.0, 0.5, 1.0, 2.0)
    for clearance_m, off_m in ((CLEARANCE_M, OFF_CENTRE_M), (NARROW_M, NARROW_OFF_M))
    for side in (0.0, 1.0, -1.0)
    for turn in (0.0, -0.5, 0.5)
)
FURTHER = tuple(  # where too few of those above have enough room
    Approach(turn_rad=turn, aside=aside, off_centre_m=off_centre, by_tip=by_tip, tilt_rad=tilt)
    for by_tip in (False, True)
    for tilt in (0.0, 0.2, -0.2)
    for aside in (0.0, 1.0)
    for off_centre in (0.0, OFF_CENTRE_M, -OFF_CENTRE_M)
    for turn in (0.0, -0.25, 0.25, -0.5, 0.5, -0.75, 0.75, -1.0, 1.0)
)
