"""Do the tubes have room for the procedure? From the observation alone, before the first clip.

The rule of `tissue_sim.outcome.room`, on what is seen: lengths of the tubes, whether they cross in
the endoscope's picture, and whether there is a third one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from planner.command import Structure
from planner.seen.duct_side import structure_seen
from planner.seen.next_task import length_m, length_std_m
from planner.task import Tube
from tissue_sim.frames import Array
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, clips_needed, needed_m
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import HELD_PINCH_N

SURE = 2.0  # standard deviations; within them it is decided when the first clip is due
LIKELY = 0.5  # chance of a third tube, or share of looks in which the tubes cross
SIDES: tuple[Tube, Tube] = ("left", "right")


@dataclass(kw_only=True)
class _Length:
    """The weighted mean of a tube's observed lengths, and the standard deviation of the best."""

    weight: float = 0.0
    total_m: float = 0.0
    std_m: float = math.inf

    def add(self, seen_m: float, std_m: float) -> None:
        weight = 1.0 / (std_m**2 + 1e-8)
        self.weight += weight
        self.total_m += weight * seen_m
        self.std_m = min(self.std_m, std_m)

    @property
    def mean_m(self) -> float:
        return self.total_m / self.weight if self.weight > 0.0 else math.inf


class RoomSeen:
    """Collects observations of one patient's tubes until the first clip."""

    def __init__(self) -> None:
        self._lengths: dict[Structure, _Length] = {"duct": _Length(), "artery": _Length()}
        self._at_rest: dict[Structure, _Length] = {"duct": _Length(), "artery": _Length()}
        self._n, self._crossed, self._third = 0, 0, 0.0

    def see(self, seen: Observation) -> None:
        """Take in one observation."""
        for side in SIDES:
            tube = structure_seen(side, seen)
            long_m, std_m = length_m(side, seen), length_std_m(side, seen)
            self._lengths[tube].add(long_m, std_m)
            if seen.pinch_n < HELD_PINCH_N:
                self._at_rest[tube].add(long_m, std_m)
        self._n += 1
        self._crossed += tubes_cross(seen)
        self._third += seen.third_tube

    def needs(self, side: Tube, seen: Observation) -> int:
        """Return how many clips a tube needs, by its length before anything pulled at it.

        Traction makes a tube up to 12 % longer, and clips make it longer still.
        """
        tube = structure_seen(side, seen)
        return clips_needed(tube, self._at_rest[tube].mean_m)

    def why_call(self, *, due: bool) -> str | None:
        """Return why a person must be called, in a surgeon's words; None if there is no reason.

        Args:
            due: the first clip is next, so that what is uncertain must be decided now.
        """
        reasons = []
        for tube, length in self._lengths.items():
            short_m = needed_m(tube, FEWEST_CLIPS) - length.mean_m
            if length.weight > 0.0 and short_m > (0.0 if due else SURE * length.std_m):
                reasons.append(
                    f"The {tube} looks {1e3 * length.mean_m:.1f} mm long: a clip on either side of"
                    f" a cut needs {1e3 * needed_m(tube, FEWEST_CLIPS):.1f} mm."
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
