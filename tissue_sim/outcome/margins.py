"""How far are the clips in place from the limits of success?"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from tissue_sim.field import Field
from tissue_sim.outcome.predicates import (
    beside_cut,
    cuffs_m,
    gap_between_m,
    good_clips,
    required_pull_n,
    station_m,
)
from tissue_sim.surgery.clip import Clip, closure, grip_n, holding_forces_n
from tissue_sim.thresholds import (
    CLIP_MAX_SLIP_M,
    CLIP_MAX_TILT_RAD,
    CLIP_MIN_GAP_M,
    CUFF_MIN_M,
    LUMEN_CLOSED,
    TEST_PULL_N,
)


@dataclass(frozen=True, kw_only=True)
class Margin:
    """The worst value of a measure over the clips in place, with its limit, in SI units.

    Attributes:
        at_least: whether the limit is a lower bound.
    """

    measure: str
    value: float
    limit: float
    at_least: bool


def margins(field: Field) -> Iterator[Margin]:
    """Yield the margin of each measure that applies to some clip; call it after the test pull."""
    placed = [(tube, clip) for tube in field.organ.tubes for clip in good_clips(field, tube)]
    for measure, values, limit in (
        ("clip tilt", [c.crossings[0].tilt_rad for _, c in placed], CLIP_MAX_TILT_RAD),
        ("lumen", [closure(field.tubes, c, tube) for tube, c in placed], LUMEN_CLOSED),
        ("clip slip", [c.slid_m for c in field.record.clips if c.crossings], CLIP_MAX_SLIP_M),
    ):
        if values:
            yield Margin(measure=measure, value=float(max(values)), limit=limit, at_least=False)
    for measure, values, limit in (
        (
            "clip gap",
            [g for tube in field.organ.tubes for g in _gaps_m(field, tube)],
            CLIP_MIN_GAP_M,
        ),
        ("cuff", [c for tube in field.organ.tubes for c in _cuffs_m(field, tube)], CUFF_MIN_M),
        ("clip hold", [_hold_n(field, c, tube) for tube, c in placed], TEST_PULL_N),
    ):
        if values:
            yield Margin(measure=measure, value=float(min(values)), limit=limit, at_least=True)


def _gaps_m(field: Field, tube: str) -> list[float]:
    """Return the distances between the edges of neighbouring clips."""
    ordered = sorted(good_clips(field, tube), key=lambda clip: station_m(clip, tube))
    return [gap_between_m(low, high, tube) for low, high in pairwise(ordered)]


def _cuffs_m(field: Field, tube: str) -> list[float]:
    """Return the lengths of tissue between a cut and the clips beside it."""
    clips, cuffs = good_clips(field, tube), list[float]()
    for cut in (c for c in field.record.cuts if c.tube == tube):
        low, high = beside_cut(cut, clips, tube)
        if low and high:
            cuffs.append(cuffs_m(cut, low[-1], high[0]))
    return cuffs


def _hold_n(field: Field, clip: Clip, tube: str) -> float:
    """Return the largest pull that a clip holds, along its tube or across it.

    Where less than `TEST_PULL_N` is required, on a thin vessel, the pull is larger in proportion.
    """
    held_n = min(holding_forces_n(field.tubes, clip, grip_n(field.tubes, clip)))
    return held_n * TEST_PULL_N / required_pull_n(field.tubes, tube)
