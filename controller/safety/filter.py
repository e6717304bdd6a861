"""The safety filter: the nearest command to the one asked for that keeps every limit and interlock.

It acts between policy and robot. A command that keeps all bounds passes unchanged. Otherwise a
quadratic program finds the nearest motion that keeps them (Ames et al., "Control barrier functions:
theory and applications", 2019, in discrete time); if there is none, both arms hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from controller.safety.bounds import N_MOTION, AllBounds, Limit
from controller.safety.filter_sense import FilterSense, Registration
from controller.safety.interlocks import INTERLOCKS
from controller.safety.ledger import Entry
from controller.safety.limits import LIMITS
from controller.safety.nearest_motion import NearestMotion
from controller.safety.situation import Situation
from planner.instruction import Instruction
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.psm import JOINT_NAMES

TURNING = np.array([name != "insertion" for name in (*JOINT_NAMES, "jaw")] * 2)
FAR = 1e3  # rad or m: larger values are no joints, and would spoil the quadratic program


@dataclass(frozen=True, kw_only=True)
class Allowed:
    """A command that may be carried out.

    Attributes:
        joints: (2, 7).
        entry: for the ledger; None if nothing was altered or overridden.
        clearance_m: smallest distance of pairs that must not touch; infinite if nothing is near.
    """

    joints: Array
    entry: Entry | None
    clearance_m: float


class SafetyFilter:
    """The safety filter of one patient and one robot.

    Attributes:
        rate: (2, 7) rate of the joints, rad/s and m/s, in the last allowed command; the filter's
            only state.
    """

    def __init__(
        self,
        registration: Registration,
        limits: Sequence[Limit] = LIMITS,
        interlocks: Sequence[Limit] = INTERLOCKS,
    ) -> None:
        self._sense = FilterSense(registration)
        self._nearest = NearestMotion()
        self._limits, self._interlocks = tuple(limits), tuple(interlocks)
        self._control_step_s = registration.step_s
        self.restart()

    def restart(self) -> None:
        """Reset the rate to zero, because the arms stand still: an episode or a tool is new."""
        self.rate: Array = np.zeros((2, 7))

    def allow(
        self, start: Array, asked: Array, instruction: Instruction, seen: Observation
    ) -> Allowed:
        """Return the allowed command when joints (2, 7) are asked for and `start` was the last one.

        Raises:
            ValueError: `asked` is not (2, 7).
        """
        if asked.shape != (2, 7):
            raise ValueError(f"safety filter: joints must be (2, 7), got {asked.shape}")
        if not (np.abs(asked) < FAR).all():  # NaN is not less
            self.restart()
            entry = Entry(
                time_s=seen.time_s, limits=(f"command: not finite, or over {FAR:g}",), held=True
            )
            return Allowed(joints=start, entry=entry, clearance_m=np.inf)
        situation = self._sense.see(start, self.rate, asked, instruction, seen)
        bounds = {rule.name: rule.bounds(situation) for rule in (*self._limits, *self._interlocks)}
        aside = {lock.name: bounds.pop(lock.name) for lock in self._set_aside(instruction)}
        kept, motion = AllBounds(bounds), situation.motion
        broken = kept.broken(motion)
        overridden = AllBounds(aside).broken(motion) if aside else ()
        if broken:
            motion = self._nearest(motion, situation.arms.weight, kept)
        share = 0.0 if motion is None else self._sense.safe_share(situation, motion)
        if share < 1.0 and motion is not None:
            broken["keep-out: on the way"] = 1.0 - share
        moved = np.zeros(N_MOTION) if motion is None else share * motion
        joints = start + moved.reshape(2, 7) if broken else asked
        self.rate = (joints - start) / self._control_step_s
        return Allowed(
            joints=joints,
            entry=_entry(situation, moved, broken, tuple(overridden), seen.time_s),
            clearance_m=_clearance_m(situation),
        )

    def _set_aside(self, instruction: Instruction) -> list[Limit]:
        return [lock for lock in self._interlocks if lock.name in instruction.overrides]


def _entry(
    situation: Situation,
    moved: Array,
    broken: dict[str, float],
    overridden: tuple[str, ...],
    time_s: float,
) -> Entry | None:
    if not broken and not overridden:
        return None
    change = moved - situation.motion
    tips = situation.arms.tip_jacobian @ change.reshape(2, 7, 1)
    return Entry(
        time_s=time_s,
        limits=tuple(broken),
        margin=next(iter(broken.values()), 0.0),
        change_m=sqrt((tips * tips).sum(axis=1).max()),
        change_rad=float((np.abs(change) * TURNING).max()),
        held=not moved.any(),
        overridden=overridden,
    )


def _clearance_m(situation: Situation) -> float:
    return float(situation.near.distance_m[situation.kept_out].min(initial=np.inf))
