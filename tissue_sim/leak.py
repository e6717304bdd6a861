"""Bile and blood from stumps that no clip closes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tissue_sim.clip import Clip, closure
from tissue_sim.cut import Cut
from tissue_sim.thresholds import BILE_RATE_M3_S, BLOOD_RATE_M3_S, LUMEN_CLOSED
from tissue_sim.tubes import Tubes

_OPEN_RATE = {
    "duct": BILE_RATE_M3_S,
    "artery": BLOOD_RATE_M3_S,
    "second artery": BLOOD_RATE_M3_S,
}


@dataclass(frozen=True, kw_only=True)
class Leak:
    """A stump that leaks: which, and how fast (m^3/s)."""

    tube: str
    side: str
    rate_m3_s: float


def leaks(tubes: Tubes, clips: Sequence[Clip], cuts: Sequence[Cut]) -> tuple[Leak, ...]:
    """Every leaking stump now. The rate goes with the open share of the tightest clip's lumen."""
    found = []
    for cut in cuts:
        for side in ("body", "gallbladder"):
            share = _open_share(tubes, clips, cut, side)
            if share > LUMEN_CLOSED:
                rate = _OPEN_RATE[cut.tube] * min(share, 1.0)
                found.append(Leak(tube=cut.tube, side=side, rate_m3_s=rate))
    return tuple(found)


def _open_share(tubes: Tubes, clips: Sequence[Clip], cut: Cut, side: str) -> float:
    """Smallest open share of the lumen between the cut and the source on one side."""
    shares = [1.0]
    for clip in clips:
        crossing = clip.on(cut.tube)
        if crossing is None or clip.lost:
            continue
        below = crossing.station_m < cut.station_m
        if below == (side == "body"):
            shares.append(closure(tubes, clip, cut.tube))
    return min(shares)
