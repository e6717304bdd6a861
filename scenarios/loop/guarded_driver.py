"""Turn a tool action into a joint command: inverse kinematics, then the safety filter."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from controller.action import ToolAction
from controller.driver import Driver, rig_in
from controller.safety.filter import SafetyFilter
from controller.safety.filter_sense import registration_of
from controller.safety.ledger import Entry, Ledger
from planner.instruction import Instruction
from scenarios.loop.wall_time import StageClock
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import JointCommand

if TYPE_CHECKING:
    from tissue_sim.world import World


class GuardedDriver:
    """Drives both arms through the safety filter, and keeps the ledger of altered commands.

    Attributes:
        filter: The safety filter; None for an episode without one.
        ledger: Each event so far in which commands were altered, with the reason.
        standstill: Whether an arm stands still although its command moves: a person is needed.
        clearance_m: Smallest distance so far of an instrument to an obstacle.
    """

    def __init__(
        self, world: World, joints: Array, clock: StageClock, *, safety_filter: bool
    ) -> None:
        self._world, self._clock = world, clock
        self.driver = Driver(rig_in(world), joints)
        self.filter = SafetyFilter(registration_of(world)) if safety_filter else None
        self.ledger, self.standstill = Ledger(), False
        self.clearance_m = math.inf
        self._news: list[Entry] = []  # alterations that observers have not received

    @property
    def joints(self) -> Array:
        """Return the joints (2, 7) commanded last, rad and m."""
        return self.driver.joints

    def command(
        self, action: ToolAction, instruction: Instruction, observation: Observation
    ) -> JointCommand:
        """Return the joint command for an action in the current endoscope frame."""
        self.driver.calibrate(rig_in(self._world))
        start, refused, limited = self.driver.joints, self.driver.refused, self.driver.limited
        with self._clock.stage("driver"):
            asked = self.driver.drive(action)
        if self.driver.refused > refused:
            self._note(Entry(time_s=observation.time_s, limits=("reach: an arm holds",)))
        elif self.driver.limited > limited:
            self._note(Entry(time_s=observation.time_s, limits=("reach: a joint at its limit",)))
        if self.filter is None:
            return asked
        with self._clock.stage("safety filter"):
            allowed = self.filter.allow(start, asked.joints, instruction, observation)
        self.clearance_m = min(self.clearance_m, allowed.clearance_m)
        self.standstill = allowed.standstill
        if allowed.entry is not None:
            self._note(allowed.entry)
        if not np.array_equal(allowed.joints, asked.joints):
            self.driver.follow(allowed.joints)
        return JointCommand(joints=allowed.joints)

    def restart(self, joints: Array) -> None:
        """Start from joints (2, 7) at rest, with the currently mounted instruments."""
        self.driver.attach(rig_in(self._world), self._world.arms.limited(joints))
        if self.filter is not None:
            self.filter.restart()

    def news(self) -> tuple[Entry, ...]:
        """Return the alterations since the last call, one for each altered command."""
        altered, self._news = tuple(self._news), []
        return altered

    def forbid(self, act: str, time_s: float) -> None:
        """Record in the ledger that a person forbade an act."""
        self._note(Entry(time_s=time_s, limits=(f"forbidden by a person: {act}",)))

    def _note(self, entry: Entry) -> None:
        self.ledger.note(entry)
        self._news.append(entry)
