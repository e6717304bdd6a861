"""Keep instruments out of obstacles, and move them out if they are inside."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controller.safety.bounds import Bounds, approach_share
from controller.safety.exemption import FIRM
from controller.safety.geometry.collision import NearPairs
from controller.safety.geometry.link_cores import FINGERS, SHAFT
from controller.safety.obstacles import MARGIN_M, TUBE_MARGIN_M
from controller.safety.situation import Situation
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.tools.instruments import Instrument

KEEP_OUT = "keep-out"
STEADY = FIRM | frozenset(AT_RISK)  # the ligament holds the structures at risk
TIME_CONSTANT_S = 0.1  # assumed: at 1 cm from the margin 0.1 m/s
LEAVE_M_S = 0.01  # speed at which an instrument moves out, assumed


def keep_out_of_obstacles(situation: Situation) -> Bounds:
    """Keep instruments out of every obstacle that `exemption` does not exempt.

    The distance to the margin shrinks by no more than a share of itself in a step. Within the
    margin an instrument leaves by the shortest way. If it cannot leave, it goes no deeper. It
    leaves, or gives way, faster by the speed at which the obstacle comes nearer.
    """
    near, pairs = situation.near, np.flatnonzero(situation.kept_out)
    room = near.distance_m[pairs] - np.where(near.of(*STEADY)[pairs], MARGIN_M, TUBE_MARGIN_M)
    share = approach_share(situation.step_s, TIME_CONSTANT_S)
    still = np.minimum(-share * room, situation.step_s * LEAVE_M_S)
    out = still + situation.step_s * situation.coming_m_s[pairs]
    leaves = np.flatnonzero(out > 0.0)
    lower = np.concatenate([np.minimum(out, 0.0), out[leaves]])
    pairs = np.concatenate([pairs, pairs[leaves]])
    return Bounds(
        rows=situation.parting[pairs],
        lower=lower,
        upper=np.full(len(lower), np.inf),
        what=PairNames(near, pairs, situation.instruments),
        gives=np.arange(len(lower)) >= len(out),
    )


class PairNames(Sequence[str]):
    """Describes near pairs in words on demand: the instrument and the obstacle."""

    def __init__(
        self,
        near: NearPairs,
        pairs: NDArray[np.integer],
        instruments: tuple[Instrument, Instrument],
    ) -> None:
        self._near, self._pairs, self._instruments = near, pairs, instruments

    def __len__(self) -> int:
        return len(self._pairs)

    def __getitem__(self, row: Any) -> Any:
        arm, link, obstacle, _ = self._near.pair(int(self._pairs[row]))
        part = "" if link in FINGERS else "shaft of the " if link == SHAFT else "wrist of the "
        return f"{part}{self._instruments[arm].in_words} kept off the {obstacle}"
