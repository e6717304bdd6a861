"""How much of a straight joint motion is free: nothing is jumped over, however fast it is.

Conservative advancement (Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996):
step no farther than the distance of now allows, as no point of a link moves faster than a bound
from the link lengths.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from controller.safety.collision import NO_LINK, CollisionModel, NearPairs
from controller.safety.link_cores import N_LINK, travel_m
from controller.safety.surroundings import Surroundings
from tissue_sim.frames import Array
from tissue_sim.instruments import Instrument

MOST_STEPS = 60
REACHED_M = 1e-5  # this near to the margin, the margin counts as reached

Pair = tuple[int, int, str, int]  # arm, link, obstacle, other link: as in a row of `NearPairs`


@dataclass(frozen=True, kw_only=True)
class FreeMotion:
    """What stands in the way of a motion; a pair that is missing cannot meet, or does not move.

    Attributes:
        share: pair -> how much of the motion it is sure to stay outside of the margin, 0 to 1.
            0 for a pair that is within the margin at the start: whether such a motion leads out
            is for its normal to say. Below 1 also where the steps did not suffice to prove more.
        clearance_m: pair -> the smallest distance, signed, where it was looked at: at the start,
            and on the way as often as the proof needed it.
    """

    share: dict[Pair, float]
    clearance_m: dict[Pair, float]

    @property
    def free_share(self) -> float:
        """Of the whole motion, all pairs together."""
        return min(self.share.values(), default=1.0)


def free_motion(
    model: CollisionModel,
    start: Array,
    end: Array,
    instruments: Sequence[Instrument],
    surroundings: Surroundings,
    *,
    margin_m: float = 0.0,
    near: NearPairs | None = None,
    most_steps: int = MOST_STEPS,
) -> FreeMotion:
    """Along the straight line between joints (2, 7), the surroundings at rest.

    `near`: what the model has at the start in these surroundings, if known already. Where it
    suffices to prove a small motion free, no more is looked for. After `most_steps` looks the rest
    of the motion counts as not free.
    """
    travel = travel_m(start, end, instruments)
    farthest_m = travel[:N_LINK].max() + travel[N_LINK:].max()
    stopped: dict[Pair, float] = {}
    clearance_m: dict[Pair, float] = {}
    sure = 0.0
    for _ in range(most_steps):
        within_m = margin_m + REACHED_M + (1.0 - sure) * farthest_m
        if near is None or near.within_m < within_m:
            joints = start + sure * (end - start)
            near = model.near(joints, instruments, surroundings, within_m=within_m)
        step = 1.0 - sure
        for pair, distance_m in _nearest(near).items():
            speed_m, room_m = _speed_m(pair, travel), distance_m - margin_m
            if speed_m == 0.0 or pair in stopped:
                continue
            clearance_m[pair] = min(distance_m, clearance_m.get(pair, distance_m))
            if room_m <= REACHED_M:
                stopped[pair] = sure
            else:
                step = min(step, room_m / speed_m)
        sure, near = min(sure + step, 1.0), None
        if sure == 1.0:
            break
    return FreeMotion(
        share={pair: stopped.get(pair, sure) for pair in clearance_m}, clearance_m=clearance_m
    )


def _nearest(near: NearPairs) -> dict[Pair, float]:
    """The smallest distance of each pair, over the capsules of a chain."""
    rows = zip(
        near.arm.tolist(),
        near.link.tolist(),
        near.obstacle.tolist(),
        near.other_link.tolist(),
        near.distance_m.tolist(),
        strict=True,
    )
    nearest: dict[Pair, float] = {}
    for *pair, distance_m in rows:
        key = (pair[0], pair[1], pair[2], pair[3])
        nearest[key] = min(distance_m, nearest.get(key, distance_m))
    return nearest


def _speed_m(pair: Pair, travel: Array) -> float:
    """How much nearer the two can come over the whole motion, at most."""
    arm, link, _, other_link = pair
    other = travel[N_LINK + other_link] if other_link != NO_LINK else 0.0
    return float(travel[N_LINK * arm + link] + other)
