"""On which tubes are fewer clips seen than a cut needs? From the observations alone."""

from __future__ import annotations

from controller.safety.exemption import HOLDS_N
from controller.safety.seen_obstacles import SIDES
from planner.command import Structure
from planner.seen.duct_side import structure_seen
from planner.seen.next_task import clips_on, length_m, length_std_m
from tissue_sim.outcome.clip_rule import clips_needed
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.sensing.observation import Observation

SURE = 2.0  # standard deviations of a tube's length


class ClipsSeen:
    """Remembers how long the tubes of one patient were before anything pulled at them.

    Traction makes a tube up to 12 % longer: a short one would seem to have room for one more clip.
    A third clip is demanded only where the tube surely has room for it.
    """

    def __init__(self) -> None:
        self._n = 0
        self._total_m: dict[Structure, float] = {"duct": 0.0, "artery": 0.0}
        self._std_m: dict[Structure, float] = {"duct": 0.0, "artery": 0.0}

    def follow(self, seen: Observation) -> None:
        """Take in one observation."""
        at_rest = seen.n_clips == 0 and seen.pinch_n < HOLDS_N
        if self._n == 0 or at_rest:
            self._n += 1
            for side in SIDES:
                name = structure_seen(side, seen)
                self._total_m[name] += length_m(side, seen)
                self._std_m[name] = length_std_m(side, seen)

    def lacking(self, seen: Observation) -> frozenset[str]:
        """Return the structures that lack clips for a cut; those at risk always do."""
        bare = {
            name
            for side in SIDES
            if clips_on(side, seen) < self._needed(name := structure_seen(side, seen))
        }
        return frozenset({*bare, *AT_RISK})

    def _needed(self, tube: Structure) -> int:
        return clips_needed(tube, self._total_m[tube] / self._n - SURE * self._std_m[tube])
