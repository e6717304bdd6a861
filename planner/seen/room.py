"""Do the tubes have room for the procedure? From the observation alone, before the first clip.

The rule of `tissue_sim.outcome.room`, on what is seen: lengths of the tubes, whether they cross in
the endoscope's picture, and whether there is a third one.
"""

from __future__ import annotations

from itertools import pairwise

from planner.command import TUBES
from planner.seen.duct_side import structure_seen
from tissue_sim.frames import Array
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m
from tissue_sim.sensing.observation import Observation

# By how many standard deviations a tube must look too short. Before the first clip is due a call
# can wait until it is certain. Then half of one, some 0.3 mm, spares most needless calls: 3 of 43
# operable patients were called with a quarter (0.15 mm). A tube that is short by so little takes
# its clips by the tolerance of 0.8 mm in the clip rule's `CUT_ROOM_M`.
SURE, DUE = 2.0, 0.5
LIKELY = 0.5  # chance of a third tube, or share of looks in which the tubes cross


class RoomSeen:
    """Collects observations of one patient's tubes until the first clip."""

    def __init__(self) -> None:
        self._n, self._crossed, self._third = 0, 0, 0.0

    def see(self, seen: Observation) -> None:
        """Take in one observation."""
        self._n += 1
        self._crossed += tubes_cross(seen)
        self._third += seen.third_tube

    def why_call(self, seen: Observation, *, due: bool) -> str | None:
        """Return why a person must be called, in a surgeon's words; None if there is no reason.

        Args:
            seen: the last observation that was taken in.
            due: the first clip is next, so that what is uncertain must be decided now.
        """
        reasons = []
        for side, length_m, std_m in zip(
            TUBES, seen.rest_length_m, seen.rest_length_std_m, strict=True
        ):
            tube = structure_seen(side, seen)
            needs_m = needed_m(tube, FEWEST_CLIPS)
            if needs_m - length_m > (DUE if due else SURE) * std_m:
                reasons.append(
                    f"The {tube} looks {1e3 * length_m:.1f} mm long: a clip on either side of"
                    f" a cut needs {1e3 * needs_m:.1f} mm."
                )
        if self._crossed > LIKELY * self._n:
            reasons.append("The artery seems to cross the duct: a person must deal with it.")
        if self._third > LIKELY * self._n:
            reasons.append("There seems to be a second artery: a person must deal with it.")
        return " ".join(reasons) or None


def tubes_cross(seen: Observation) -> bool:
    """Return whether the tubes' centrelines cross in the endoscope's picture."""
    left, right = (line[:, :2] / line[:, 2:] for line in (seen.left_tube_m, seen.right_tube_m))
    return any(_meet(*a, *b) for a in pairwise(left) for b in pairwise(right))


def _meet(a: Array, b: Array, c: Array, d: Array) -> bool:
    """Return whether the segments a b and c d cross, each end (2,)."""
    apart = _turn(a, b, c) * _turn(a, b, d) < 0.0
    return bool(apart and _turn(c, d, a) * _turn(c, d, b) < 0.0)


def _turn(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
