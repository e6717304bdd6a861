"""Are there clips enough for a cut, and room beside them? From the observations alone."""

from __future__ import annotations

import numpy as np

from controller.perception.lines import between_jaws, nearest_on
from controller.safety.exemption import HOLDS_N
from controller.safety.seen_obstacles import SIDES
from planner.command import Structure
from planner.seen.duct_side import structure_seen
from planner.seen.next_task import ON_TUBE_M, clips_on, length_m, length_std_m
from planner.task import Tube
from tissue_sim.outcome.clip_rule import clips_needed
from tissue_sim.outcome.jaws import MOUTHS
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.sensing.observation import (
    MAX_CLIPS,
    N_POINTS,
    SCISSORS,
    TUBE_POINTS,
    Observation,
)
from tissue_sim.thresholds import CLIP_MIN_GAP_M, CUFF_MIN_M
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.clip_size import CLIP_WIDTH_M

SURE = 2.0  # standard deviations of a tube's length
UNSURE = 0.5  # standard deviations of a clip's place, by which it may lie farther away; assumed


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

    def crowded(self, seen: Observation, between: frozenset[str]) -> frozenset[str]:
        """Return those of the structures between the right jaws on which a clip is too near.

        A clip must be `CLIP_MIN_GAP_M` from the next one, a cut leaves `CUFF_MIN_M` beside it.
        """
        cuts = seen.tools[RIGHT_ARM] == SCISSORS
        if not (cuts or seen.clip_loaded):
            return frozenset()
        least_m = 0.5 * CLIP_WIDTH_M + CUFF_MIN_M if cuts else CLIP_WIDTH_M + CLIP_MIN_GAP_M
        return frozenset(
            name
            for side in SIDES
            if (name := structure_seen(side, seen)) in between
            and self._to_clip_m(side, name, seen) < least_m
        )

    def _to_clip_m(self, side: Tube, name: Structure, seen: Observation) -> float:
        """Return how far the right jaws' plane may be from the next clip on a tube at rest, m."""
        line = seen.left_tube_m if side == "left" else seen.right_tube_m
        reach_m, _ = MOUTHS[seen.tools[RIGHT_ARM]]
        k, share, _ = between_jaws(line, seen.tips_endoscope[RIGHT_ARM], reach_m)
        clips_m = seen.clips_m[: min(seen.n_clips, MAX_CLIPS)]
        places = [nearest_on(line, clip_m) for clip_m in clips_m]
        nearest_m = np.inf
        for number, (at, beyond, away_m) in enumerate(places):
            if away_m <= ON_TUBE_M:
                apart = abs(at + beyond - k - share) / (TUBE_POINTS - 1)
                unsure_m = UNSURE * float(seen.std_m[N_POINTS - MAX_CLIPS + number])
                nearest_m = min(nearest_m, apart * self._total_m[name] / self._n + unsure_m)
        return nearest_m

    def _needed(self, tube: Structure) -> int:
        return clips_needed(tube, self._total_m[tube] / self._n - SURE * self._std_m[tube])
