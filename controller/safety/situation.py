"""The inputs of limits and interlocks when they bound the next control step."""

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

    Rows: left, right arm. Joints (7,) are those of a `JointCommand`: rad, m for the insertion. A
    motion (14,) is the change of both arms' joints in this control step, the left arm's first.

    Attributes:
        step_s: length of the control step.
        instruments: on the left and right arm.
        start: (2, 7) joints commanded last.
        rate: (2, 7) rate of change (per s) of the step before.
        asked: (2, 7) joints asked for.
        arms: how the arms move with their joints, and with the motion asked for.
        near: pairs of instrument and obstacle that are near each other, at `start`.
        parting: (n, 14) from a motion to the change of each near pair's distance, m.
        tool_force_n: (2, 3) force of the tissue on each instrument, world frame.
        pinch_n: of the grasper's jaws on the tissue between them.
        shaft_offset_m: (2,) distance of each measured shaft from its remote centre.
        instruction: the present one.
        worked_on: structures ("duct", "artery") that the left and the right jaws work on.
        between_jaws: structures between the right tool's jaws; empty unless the jaws close.
        lacking_clips: those of `between_jaws` on which fewer clips are seen than must be there
            before a cut.
        crowded: those of `between_jaws` on which a clip is too near to the jaws.
    """

    step_s: float
    instruments: tuple[Instrument, Instrument]
    start: Array
    rate: Array
    asked: Array
    arms: ArmMotion
    near: NearPairs
    parting: Array
    tool_force_n: Array
    pinch_n: float
    shaft_offset_m: Array
    instruction: Instruction
    worked_on: WorkedOn
    between_jaws: frozenset[str]
    lacking_clips: frozenset[str]
    crowded: frozenset[str]

    @cached_property
    def motion(self) -> Array:
        """Return the motion (14,) asked for."""
        return (self.asked - self.start).ravel()

    @cached_property
    def kept_out(self) -> NDArray[np.bool_]:
        """Return (n,) which near pairs must not touch; of a chain only the foremost."""
        return kept_out(self.near, self.worked_on) & self.near.foremost
