"""Filter commands: find the command nearest to the request that keeps each limit and interlock.

The safety filter acts between policy and robot. A command that keeps all bounds passes unchanged.
Otherwise a quadratic program finds the nearest motion that keeps the bounds. If no motion keeps
them, both arms hold. The source is Ames et al., "Control barrier functions: theory and
applications", 2019, in discrete time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from controller.safety.bounds import ARMS, N_MOTION, AllBounds, Bounds, Limit
from controller.safety.filter_sense import FilterSense, Registration
from controller.safety.interlocks import INTERLOCKS, JAW_LOCKS
from controller.safety.ledger import Entry
from controller.safety.limits import LIMITS
from controller.safety.limits.keep_out import KEEP_OUT
from controller.safety.nearest_motion import NearestMotion
from controller.safety.situation import Situation
from controller.safety.way_out import WayOut
from planner.instruction import Instruction
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.psm import JOINT_NAMES

TURNING = np.array([name != "insertion" for name in (*JOINT_NAMES, "jaw")] * 2)
JAW_DEAD_BAND_RAD = 0.02  # a jaw that is held open by less than this is no event; assumed
FAR = 1e3  # rad or m: larger values are no joints, and would spoil the quadratic program


@dataclass(frozen=True, kw_only=True)
class Allowed:
    """A command that may be carried out.

    Attributes:
        joints: (2, 7) commanded joints.
        entry: Entry for the ledger. None if nothing was altered or overridden, or only a jaw within
            the dead band.
        clearance_m: Smallest distance of pairs that must not touch; infinite if nothing is near.
        standstill: Whether an arm with commands to move stood so long that a person is needed.
    """

    joints: Array
    entry: Entry | None
    clearance_m: float
    standstill: bool = False


@dataclass(frozen=True, kw_only=True)
class _Kept:
    """The allowed part of a motion.

    Attributes:
        motion: (14,) the allowed motion.
        broken: Excess of the requested motion over each broken limit, by the limit's name.
        overridden: Names of the interlocks that the motion breaks and a person set aside.
    """

    motion: Array
    broken: dict[str, float]
    overridden: tuple[str, ...]


class SafetyFilter:
    """The safety filter of one patient and one robot.

    Attributes:
        rate: (2, 7) rate of the joints, rad/s and m/s, in the last allowed command.
    """

    def __init__(
        self,
        registration: Registration,
        limits: Mapping[str, Limit] = LIMITS,
        interlocks: Mapping[str, Limit] = INTERLOCKS,
    ) -> None:
        self._sense = FilterSense(registration)
        self._nearest = NearestMotion()
        self._limits, self._interlocks = limits, interlocks
        self._control_step_s = registration.step_s
        self.restart()

    def restart(self) -> None:
        """Forget the rate and all standstills: the arms rest, and an episode or a tool is new."""
        self.rate: Array = np.zeros((2, 7))
        self._way_out = WayOut(self._control_step_s)

    def allow(
        self, start: Array, asked: Array, instruction: Instruction, observation: Observation
    ) -> Allowed:
        """Return the allowed command for requested joints (2, 7) after the last command `start`.

        Raises:
            ValueError: `asked` is not (2, 7).
        """
        if asked.shape != (2, 7):
            raise ValueError(f"safety filter: joints must be (2, 7), got {asked.shape}")
        if not (np.abs(asked) < FAR).all():  # NaN is not less
            self.restart()
            return _refused(start, observation.time_s)
        if instruction.speed != 1.0:
            asked = start + instruction.speed * (asked - start)
        if _is_a_persons(instruction):
            self._way_out.rest()
        else:
            asked = self._way_out.lead(start, asked, instruction.task, observation)
        backing = self._way_out.backing
        situation = self._sense.build(start, self.rate, asked, instruction, observation)
        kept = self._kept(situation)
        joints = start + kept.motion.reshape(2, 7) if kept.broken else asked
        self.rate = (joints - start) / self._control_step_s
        tips = situation.arms.tip_jacobian
        self._way_out.note(_tips_m(tips, situation.motion), _tips_m(tips, kept.motion))
        if backing is not None:
            why = f"standstill: {ARMS[backing]} arm backs off"
            kept = replace(kept, broken={why: 0.0, **kept.broken})
        return Allowed(
            joints=joints,
            entry=_entry(situation, kept, observation.time_s),
            clearance_m=_clearance_m(situation),
            standstill=self._way_out.calls,
        )

    def _kept(self, situation: Situation) -> _Kept:
        """Return the nearest motion that keeps all bounds, as far as its way is free."""
        bounds, overrides = self.bounds(situation), situation.instruction.overrides
        aside = {name: bounds.pop(name) for name in self._interlocks if name in overrides}
        in_force, motion = AllBounds(bounds), situation.motion
        broken = in_force.broken(motion)
        overridden = tuple(AllBounds(aside).broken(motion)) if aside else ()
        if broken:
            motion = self._nearest(motion, situation.arms.weight, in_force)
        if motion is None:
            return _Kept(motion=np.zeros(N_MOTION), broken=broken, overridden=overridden)
        share = self._sense.safe_share(situation, motion)
        if share < 1.0:
            broken["keep-out: on the way"] = 1.0 - share
        return _Kept(motion=share * motion, broken=broken, overridden=overridden)

    def bounds(self, situation: Situation) -> dict[str, Bounds]:
        """Return the bounds of each limit and interlock, by its name in the ledger."""
        rules = {**self._limits, **self._interlocks}
        return {name: rule(situation) for name, rule in rules.items()}


def _is_a_persons(instruction: Instruction) -> bool:
    """Return whether a person lets the arms hold or moves one; then no arm backs off by itself."""
    if instruction.source == "human":
        return instruction.hold or instruction.correction is not None
    return instruction.hold and bool(instruction.forbidden)


def _refused(start: Array, time_s: float) -> Allowed:
    """Return the answer to a command that has no valid joints: both arms hold."""
    entry = Entry(time_s=time_s, limits=(f"command: not finite, or over {FAR:g}",), held=True)
    return Allowed(joints=start, entry=entry, clearance_m=np.inf)


def _entry(situation: Situation, kept: _Kept, time_s: float) -> Entry | None:
    if not kept.overridden and _is_no_event(situation, kept.broken):
        return None
    change = kept.motion - situation.motion
    tips = _tips_m(situation.arms.tip_jacobian, change)
    kept_off = any(name.startswith(KEEP_OUT) for name in kept.broken)
    return Entry(
        time_s=time_s,
        limits=tuple(kept.broken),
        margin=next(iter(kept.broken.values()), 0.0),
        nearest_m=_clearance_m(situation) if kept_off else None,
        change_m=sqrt((tips * tips).sum(axis=1).max()),
        change_rad=float((np.abs(change) * TURNING).max()),
        held=not kept.motion.any(),
        overridden=kept.overridden,
    )


def _is_no_event(situation: Situation, broken: dict[str, float]) -> bool:
    """Return whether the filter altered at most a little closing of a jaw without a task."""
    jaws = all(name.partition(":")[0] in JAW_LOCKS for name in broken)
    idle = not situation.instruction.task.is_deed
    return jaws and (not broken or (idle and max(broken.values()) < JAW_DEAD_BAND_RAD))


def _tips_m(tip_jacobian: Array, motion: Array) -> Array:
    """Return the displacement (2, 3) of the tips by a motion (14,)."""
    return (tip_jacobian @ motion.reshape(2, 7, 1))[..., 0]


def _clearance_m(situation: Situation) -> float:
    return float(situation.near.distance_m[situation.kept_out].min(initial=np.inf))
