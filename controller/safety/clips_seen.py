"""Decide from the observation alone whether a cut has enough clips, and room beside them."""

from __future__ import annotations

import numpy as np

from planner.scene.duct_side import structure_seen
from planner.scene.next_task import ON_TUBE_M, clip_kinds, clips_needed_on, clips_on
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.tube_names import Tube
from tissue_sim.sensing.observation import MAX_CLIPS, N_POINTS, TUBE_POINTS, Observation
from tissue_sim.sensing.polyline import nearest_on, nearest_to_jaws
from tissue_sim.thresholds import CLIP_MIN_GAP_M, CUFF_MIN_M
from tissue_sim.tools.arms import RIGHT_ARM

SURE = 2.0  # standard deviations of a tube's length; assumed
UNSURE = 0.5  # standard deviations by which a clip may lie farther away; assumed


def lacking_clips(observation: Observation) -> frozenset[str]:
    """Return the structures that lack clips for a cut; structures at risk always do.

    A third clip is required only where a tube surely has room for it.
    """
    bare = {
        structure_seen(tube, observation)
        for tube in observation.tubes
        if clips_on(tube, observation) < clips_needed_on(tube, observation, stds=-SURE)
    }
    return frozenset({*bare, *AT_RISK})


def crowded_by_clips(observation: Observation, between: frozenset[str]) -> frozenset[str]:
    """Return the structures between the right jaws on which a clip is too near.

    A clip must be `CLIP_MIN_GAP_M` from the next clip; a cut leaves `CUFF_MIN_M` beside a clip.
    """
    tool = observation.right_instrument
    if not (tool.deed == "cut" or observation.clip_loaded):
        return frozenset()
    least_m = 0.5 * tool.clip.width_m + CLIP_MIN_GAP_M if tool.clip else CUFF_MIN_M
    return frozenset(
        name
        for tube in observation.tubes
        if (name := structure_seen(tube, observation)) in between
        and _to_clip_m(tube, observation) < least_m
    )


def _to_clip_m(tube: Tube, observation: Observation) -> float:
    """Return the possible distance of the right jaws' plane to the next clip's edge, m.

    The distance is along the tube at rest.
    """
    line = observation.tube_m(tube)
    reach_m, _ = observation.right_instrument.mouth_m
    k, share, _ = nearest_to_jaws(line, observation.tips_endoscope[RIGHT_ARM], reach_m)
    clips_m = observation.clips_m[: min(observation.n_clips, MAX_CLIPS)]
    places = [nearest_on(line, clip_m) for clip_m in clips_m]
    nearest_m = np.inf
    kinds = clip_kinds(tube, observation)
    for number, ((at, beyond, away_m), kind) in enumerate(zip(places, kinds, strict=True)):
        if away_m <= ON_TUBE_M:
            apart = abs(at + beyond - k - share) / (TUBE_POINTS - 1)
            unsure_m = UNSURE * float(observation.std_m[N_POINTS - MAX_CLIPS + number])
            apart_m = apart * observation.length_m(tube)
            nearest_m = min(nearest_m, apart_m + unsure_m - 0.5 * kind.width_m)
    return nearest_m
