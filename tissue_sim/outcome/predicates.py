"""Which parts of the procedure are done? The predicates read the physical state only."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tissue_sim.field import Field
from tissue_sim.frames import Array
from tissue_sim.outcome.clip_rule import USUAL_CLIPS, clips_needed
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.tubes import Tubes
from tissue_sim.patient.walls import strength_n
from tissue_sim.surgery.clip import Clip, closure
from tissue_sim.surgery.cut import Cut
from tissue_sim.surgery.grasp import INFUNDIBULUM_RINGS, LEFT_FINGERS, inward_n
from tissue_sim.thresholds import (
    CLIP_MAX_SLIP_M,
    CLIP_MAX_TILT_RAD,
    CLIP_MIN_GAP_M,
    CUFF_MIN_M,
    GRASP_HOLD_S,
    GRASP_MAX_JAW_RAD,
    GRASP_MIN_TRACTION_N,
    HELD_PINCH_N,
    LUMEN_CLOSED,
    RETRACTED_M,
    SPREAD_MIN_M,
    TAUT_MIN,
    TEST_PULL_N,
    TEST_PULL_SHARE,
)
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import Instrument, applier_for, applier_of


def gallbladder_grasped(field: Field) -> bool:
    """Return whether the grasp holds the infundibulum.

    The grasp must last for a second without a slip, pull the tissue taut, and spread the tubes.
    """
    grasp = field.record.grasp
    steady = field.record.time_s - grasp.since_s >= GRASP_HOLD_S
    taut = grasp.traction_n >= GRASP_MIN_TRACTION_N
    return gallbladder_held(field) and steady and taut and tubes_spread(field.tubes)


def gallbladder_held(field: Field) -> bool:
    """Return whether closed jaws press on the infundibulum from both sides."""
    closed = bool(field.arms.joints[LEFT_ARM, 6] <= GRASP_MAX_JAW_RAD)
    infundibulum = field.organ.sac_rings[:INFUNDIBULUM_RINGS].ravel()
    tool = field.arms.T_world_tool()[LEFT_ARM]
    pressed_n = min(inward_n(field.tissue, infundibulum, LEFT_FINGERS, tool))
    return closed and pressed_n >= HELD_PINCH_N


def grasper_pressed_n(field: Field) -> float:
    """Return the smaller of the grasper jaws' inward normal forces on any tissue, N."""
    everything = np.arange(field.tissue.n_vertex(), dtype=np.int32)
    tool = field.arms.T_world_tool()[LEFT_ARM]
    return min(inward_n(field.tissue, everything, LEFT_FINGERS, tool))


def grasper_hooked(field: Field) -> bool:
    """Return whether a jaw presses tissue outwards, and would hook behind a fold when retracted."""
    return grasper_pressed_n(field) <= -HELD_PINCH_N


def tubes_spread(tubes: Tubes) -> bool:
    """Return whether both tubes are straight, with room between their walls."""
    return bool(min(straightness(tubes, t) for t in TUBES) >= TAUT_MIN) and (
        gap_m(tubes) >= SPREAD_MIN_M
    )


def straightness(tubes: Tubes, tube: str) -> float:
    """Return the distance between a tube's ends over its length at rest; above 1: stretched."""
    centres = tubes.centres(tube)
    return float(np.linalg.norm(centres[-1] - centres[0]) / tubes.length_m[tube])


def gap_m(tubes: Tubes) -> float:
    """Return the smallest distance between duct and artery walls over their middle halves."""
    duct, artery = (_middle(tubes.centres(t)) for t in TUBES)
    apart = np.linalg.norm(duct[:, None] - artery[None], axis=-1).min()
    return float(apart - sum(tubes.radius_m(t) for t in TUBES))


def applier_on(field: Field, tube: str) -> Instrument:
    """Return the applier for a tube: of the first clip on it, else by the tube's width."""
    kinds = (clip.kind for clip in field.record.clips if not clip.lost and clip.on(tube))
    kind = next(kinds, None)
    return applier_of(kind) if kind else applier_for(2.0 * field.tubes.radius_m(tube))


def clips_needed_on(field: Field, tube: str) -> int:
    """Return how many clips a tube must have before it is cut."""
    return clips_needed(tube, field.tubes.length_m[tube], applier_on(field, tube))


def good_clips(field: Field, tube: str) -> tuple[Clip, ...]:
    """Return the clips on this tube alone that are complete, square and apart, and close it.

    The highest clip on a tube leaves with the gallbladder, so it may also hold the gallbladder.
    """
    on_tube = [clip for clip in field.record.clips if not clip.lost and clip.on(tube)]
    highest = max(on_tube, key=lambda clip: station_m(clip, tube), default=None)
    placed: list[Clip] = []
    for clip in on_tube:
        allowed = clip is highest or not clip.on_sac
        if allowed and _well_placed(field.tubes, clip, tube) and _apart(clip, placed, tube):
            placed.append(clip)
    return tuple(placed)


def clip_placed(field: Field, tube: str, k: int) -> bool:
    """Return whether the first k clips (1 to 3) are good, each further from the fixed end.

    If the tube needs fewer clips, that number is sufficient.
    """
    n = min(k, clips_needed_on(field, tube))
    clips = good_clips(field, tube)[:n]
    stations = [station_m(clip, tube) for clip in clips]
    staying = clips[: clips_needed_on(field, tube) - 1]
    rising = all(a < b for a, b in pairwise(stations))
    return len(stations) == n and rising and not any(clip.on_sac for clip in staying)


def right_arm_back(field: Field, from_m: float = RETRACTED_M) -> bool:
    """Return whether the right tip is this far from every tube, and the arm touches no tissue."""
    tip = field.arms.T_world_tool()[RIGHT_ARM][:3, 3]
    away = [np.linalg.norm(field.tubes.centres(t) - tip, axis=1) for t in field.organ.tubes]
    distance = min(float(a.min()) for a in away)
    touching = field.tissue.host("contact_shape")[0, : field.tissue.n_vertex()] >= 4
    return distance >= from_m and not touching.any()


def tube_cut(field: Field, tube: str) -> bool:
    """Return whether the tube is cut once, between good clips, with a cuff on both sides.

    The tube must be in two parts, and not torn. All clips that the tube needs but one, usually two
    of three, must be below the cut and stay in the patient. One clip must be above the cut.
    """
    cuts = [c for c in field.record.cuts if c.tube == tube]
    torn = any(t.tube == tube for t in field.record.tears)
    if torn or len(cuts) != 1 or not field.tubes.in_two_parts(tube):
        return False
    stay = clips_needed_on(field, tube) - 1
    low, high = beside_cut(cuts[0], good_clips(field, tube), tube)
    low = [clip for clip in low if not clip.on_sac]
    return len(low) >= stay and bool(high) and cuffs_m(cuts[0], low[-1], high[0]) >= CUFF_MIN_M


def tube_severed(field: Field, tube: str) -> bool:
    """Return whether the tube is cut into two parts, well or badly."""
    return any(c.tube == tube for c in field.record.cuts) and field.tubes.in_two_parts(tube)


def required_pull_n(tubes: Tubes, tube: str) -> float:
    """Return the pull in the end that a clip on this tube must hold, N."""
    return min(TEST_PULL_N, TEST_PULL_SHARE * strength_n(tube, tubes.radius_m(tube)))


def stumps_hold(field: Field) -> bool:
    """Return whether every clip put on a tube still holds at its original place, and nothing leaks.

    A clip that was never on a tube, such as a dropped one, does not count.
    """
    clips = field.record.clips
    firm = not any(c.detached or c.slid_m > CLIP_MAX_SLIP_M for c in clips)
    return firm and not field.record.leaks


def untouched(field: Field) -> bool:
    """Return whether nothing irreversible is done: no clip on tissue, no cut, no injury."""
    r = field.record
    clipped = any(clip.crossings or clip.on_sac for clip in r.clips)
    return not (clipped or r.cuts or r.injuries)


def procedure_flags(field: Field) -> dict[str, bool]:
    """Return which parts of the procedure are done now, regardless of the history.

    The third tube's parts belong only to a patient with a second artery.
    """
    flags = {"gallbladder grasped": gallbladder_grasped(field)}
    for side in field.anatomy.tubes:
        tube = field.anatomy.structure(side)
        for k in range(1, USUAL_CLIPS + 1):
            flags[f"{side} clip {k}"] = clip_placed(field, tube, k)
        flags[f"{side} cut"] = tube_cut(field, tube)
    flags["right arm back"] = right_arm_back(field)
    flags["no injury"] = not field.record.injuries
    return flags


def _well_placed(tubes: Tubes, clip: Clip, tube: str) -> bool:
    crossing = clip.on(tube)
    return (
        crossing is not None
        and not clip.lost
        and len(clip.crossings) == 1
        and all(clip.complete)
        and crossing.tilt_rad <= CLIP_MAX_TILT_RAD
        and closure(tubes, clip, tube) < LUMEN_CLOSED
        and station_m(clip, tube) >= 0.5 * clip.kind.width_m
    )


def _apart(clip: Clip, placed: Sequence[Clip], tube: str) -> bool:
    return all(gap_between_m(clip, p, tube) >= CLIP_MIN_GAP_M for p in placed)


def gap_between_m(clip: Clip, other: Clip, tube: str) -> float:
    """Return the distance between the edges of two clips on a tube, m; negative if they overlap."""
    apart_m = abs(station_m(clip, tube) - station_m(other, tube))
    return apart_m - 0.5 * (clip.kind.width_m + other.kind.width_m)


def station_m(clip: Clip, tube: str) -> float:
    """Return a clip's place along its tube at rest, m from the fixed end.

    Raises:
        ValueError: the clip is not on this tube.
    """
    crossing = clip.on(tube)
    if crossing is None:
        raise ValueError(f"clip {clip.number} is not on the {tube}")
    return crossing.station_m


def beside_cut(cut: Cut, clips: Sequence[Clip], tube: str) -> tuple[list[Clip], list[Clip]]:
    """Return the clips below and above a cut of their tube, from the fixed end up."""
    ordered = sorted(clips, key=lambda clip: station_m(clip, tube))
    n_low = sum(station_m(clip, tube) < cut.station_m for clip in ordered)
    return ordered[:n_low], ordered[n_low:]


def cuffs_m(cut: Cut, low: Clip, high: Clip) -> float:
    """Return the shorter stump's length beyond its clip; negative for a cut elsewhere."""
    below_m = cut.station_m - station_m(low, cut.tube) - 0.5 * low.kind.width_m
    above_m = station_m(high, cut.tube) - cut.station_m - 0.5 * high.kind.width_m
    return min(below_m, above_m)


def _middle(centres: Array) -> Array:
    n = len(centres)
    return centres[n // 4 : n - n // 4]
