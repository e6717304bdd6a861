"""Define the inputs of limits and interlocks when they bound the next control step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from controller.safety.arm_motion import ArmMotion
from controller.safety.exemption import WorkedOn, kept_out
from controller.safety.geometry.collision import NearPairs
from planner.instruction import Instruction
from tissue_sim.frames import Array
from tissue_sim.tools.instruments import Instrument


@dataclass(frozen=True, kw_only=True)
class Situation:
    """The last command, the wanted command, and the surroundings of the arms.

    Rows are the left and the right arm. Joints (7,) are those of a `JointCommand`: rad, m for the
    insertion. A motion (14,) is the change of both arms' joints in this control step, the left
    arm's first.

    Attributes:
        step_s: Length of the control step.
        instruments: Instruments on the left and right arm.
        start: (2, 7) joints commanded last.
        rate: (2, 7) rate of change (per s) of the step before.
        asked: (2, 7) requested joints.
        arms: The motion of the arms with their joints, and with the requested motion.
        near: Pairs of instrument and obstacle that are near each other, at `start`.
        parting: (n, 14) from a motion to the change of each near pair's distance, m.
        coming_m_s: (n,) speed at which each near pair's obstacle comes nearer by itself.
        tool_force_n: (2, 3) force of the tissue on each instrument, world frame.
        pinch_n: Force of the grasper's jaws on the tissue between them.
        shaft_offset_m: (2,) distance of each measured shaft from its remote centre.
        instruction: The present instruction.
        worked_on: Structures ("duct", "artery") that the left and the right jaws work on.
        between_jaws: Structures between the right tool's jaws; empty unless the jaws close.
        lacking_clips: Structures of `between_jaws` with fewer observed clips than a cut requires.
        crowded: Structures of `between_jaws` on which a clip is too near to the jaws.
        partly: Tubes of `between_jaws` of which a clip would surely hold only a part.
    """

    step_s: float
    instruments: tuple[Instrument, Instrument]
    start: Array
    rate: Array
    asked: Array
    arms: ArmMotion
    near: NearPairs
    parting: Array
    coming_m_s: Array
    tool_force_n: Array
    pinch_n: float
    shaft_offset_m: Array
    instruction: Instruction
    worked_on: WorkedOn
    between_jaws: frozenset[str]
    lacking_clips: frozenset[str]
    crowded: frozenset[str]
    partly: frozenset[str]

    @cached_property
    def motion(self) -> Array:
        """Return the requested motion (14,)."""
        return (self.asked - self.start).ravel()

    @cached_property
    def kept_out(self) -> NDArray[np.bool_]:
        """Return the mask (n,) of near pairs that must not touch; of a chain only the foremost."""
        return kept_out(self.near, self.worked_on) & self.near.foremost
