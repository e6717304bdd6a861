"""Follow a person's order: a correction to its distance, a task until done or given up."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from planner.base import MOST_TRIES, PATIENCE_S
from planner.correction import DIRECTION_ENDOSCOPE, Correction
from planner.person.jaws import jaws_told
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.procedure import Procedure
from planner.procedure.task import Task
from planner.scene.observed_outcomes import is_done
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import HELD_PINCH_N

DEFAULT_M = 0.004  # a correction's distance where a person names none; assumed
REACHED_M = 5e-5  # remaining distance at which a correction is done
JAWS_S = 1.2  # time for which jaws open or close where a person names none; assumed
JAW_RAD_S = 0.3  # speed of the jaws; assumed
SLOWEST_M_S = 0.002  # a correction that is slower than this is given up; assumed
LEAST_S = 5.0  # before a correction is given up: an arm must get under way; assumed
GRAB_S, HELD_S = 40.0, 3.0  # a grab is given up, and done; assumed


@dataclass(frozen=True, kw_only=True)
class Order:
    """An order of a person.

    Attributes:
        task: The ordered task; None for the planner's task at any time.
        distance_m: Distance of a correction of an arm.
        given_s: Time at which the order was given.
    """

    task: Task | None = None
    correction: Correction | None = None
    distance_m: float = DEFAULT_M
    hold: bool = False
    confidence: float = 1.0
    given_s: float = 0.0

    def lasts(self, speed: float) -> str:
        """Return in words how long the order is in force, at a share of the usual speed."""
        if self.hold:
            return "until something else is said"
        if self.correction is None:
            return "until it is done"
        if self.correction.direction is None:
            return f"for {self.jaws_s / speed:.2g} s"
        return f"by {1e3 * self.distance_m:.3g} mm"

    @property
    def jaws_s(self) -> float:
        """Return the time for which jaws open or close at the usual speed; "a bit" takes less."""
        return JAWS_S * self.distance_m / DEFAULT_M


class OrderProgress:
    """Follows one order: the task that it requests now, and its end.

    A clip or a cut that is not observed as done in `PATIENCE_S` is tried again from further away.
    If a retraction stands behind the task, the arm retracts then. The arm also retracts first if it
    is `leaving` another place. Tool exchanges, which the robot knows, do not count: a correction
    that waits for the end of an exchange begins there. The clocks run as slowly as the arms do at
    the speed that a person wants.
    """

    def __init__(
        self,
        order: Order,
        observation: Observation,
        procedure: Procedure = CHOLECYSTECTOMY,
        leaving: Task | None = None,
    ) -> None:
        self.order, self._procedure = order, procedure
        self._start_m, self._start_rad = _tips_m(observation), observation.joints[:, -1].copy()
        self._lasted_s, self._seen_s = 0.0, order.given_s
        self._stage, self._stage_s, self._held_s = leaving or order.task, 0.0, 0.0
        self._tries, self._done = 0 if leaving else 1, False

    @property
    def task(self) -> Task | None:
        """Return the task to request now; None for the planner's task."""
        return self._stage

    def update(
        self,
        observation: Observation,
        *,
        exchanging: bool,
        speed: float,
        forbidden: Collection[str] = (),
        withheld: str = "",
    ) -> str | None:
        """Take in one control step; return in words how the order ended, None if it has not.

        Args:
            observation: The present observation.
            exchanging: Whether the nurse exchanges a tool.
            speed: Share of the usual speed that a person wants.
            forbidden: Acts that a person forbade, in words.
            withheld: Reason why the safety filter altered the last command; "" if it did not.
        """
        passed_s = 0.0 if exchanging else speed * max(observation.time_s - self._seen_s, 0.0)
        if exchanging:
            self._start_m, self._start_rad = _tips_m(observation), observation.joints[:, -1].copy()
        self._seen_s = observation.time_s
        self._lasted_s += passed_s
        self._stage_s += passed_s
        if self.order.hold:
            return None
        if self.order.correction is not None:
            return self._corrected(observation, forbidden, withheld)
        return self._carried_out(observation, passed_s)

    @property
    def is_task(self) -> bool:
        """Return whether a task was ordered, and neither a correction nor a hold."""
        return self.order.task is not None and not (self.order.hold or self.order.correction)

    def go_on(self, time_s: float) -> None:
        """Exclude the time until now, because another order was in force."""
        self._seen_s = time_s

    def left_m(self, observation: Observation) -> float | None:
        """Return the remaining distance of a correction of an arm; None for other orders."""
        correction = self.order.correction
        if correction is None or correction.direction is None:
            return None
        (arm,) = correction.rows
        moved_m = _tips_m(observation)[arm] - self._start_m[arm]
        return self.order.distance_m - float(moved_m @ DIRECTION_ENDOSCOPE[correction.direction])

    def gone_m(self, observation: Observation) -> float | None:
        """Return the distance that a correction of an arm has moved; None for other orders."""
        left_m = self.left_m(observation)
        return None if left_m is None else self.order.distance_m - left_m

    def cut_short(self, observation: Observation) -> str:
        """Return in words the progress of an order that another word ends; "" for a hold."""
        if self.order.hold:
            return ""
        if self.order.correction is not None:
            gone = self._gone(observation)
            return f"Not finished: {self.order.correction.text}, stopped after {gone}."
        task = self.order.task
        assert task is not None, "an order without a correction has a task"
        done = self._done or (not task.grasps and is_done(task, observation))
        return _end(task, done, "something else was said")

    def _gone(self, observation: Observation) -> str:
        """Return in words the finished part of a correction: "1.7 of 3 mm"."""
        if (gone_m := self.gone_m(observation)) is None:
            return f"{self._lasted_s:.1f} of {self.order.jaws_s:.2g} s"
        return f"{1e3 * gone_m:.1f} of {1e3 * self.order.distance_m:.3g} mm"

    def _corrected(
        self, observation: Observation, forbidden: Collection[str], withheld: str
    ) -> str | None:
        words, gone_m = self.order.correction, self.gone_m(observation)
        assert words is not None, "it is a correction"
        if gone_m is None:
            if self._lasted_s < self.order.jaws_s - 1e-9:
                return None
            asked_rad = JAW_RAD_S * self.order.jaws_s
            return jaws_told(words, asked_rad, self._start_rad, observation, forbidden, withheld)
        if gone_m >= self.order.distance_m - REACHED_M:
            return f"Done: {words.text} by {round(1e3 * gone_m, 1):g} mm."
        if self._lasted_s < LEAST_S + self.order.distance_m / SLOWEST_M_S:
            return None
        why = f"the safety filter: {withheld}" if withheld else "something is in the way"
        return f"Given up: {words.text}, {self._gone(observation)}; {why}."

    def _carried_out(self, observation: Observation, passed_s: float) -> str | None:
        task, stage = self.order.task, self._stage
        assert task is not None, "an order without a correction has a task"
        assert stage is not None, "it has begun"
        if task.grasps:
            return self._grabbed(task, observation, passed_s)
        over = is_done(stage, observation)
        if stage == task and (over or self._stage_s > PATIENCE_S):
            self._done = over
            retraction = self._procedure.retraction_after(task)
            if task.goes_back or retraction is None:
                return _end(task, over, "something is in the way")
            self._go_on_with(retraction)  # done, or for another try
        elif stage != task and (over or self._stage_s > PATIENCE_S):
            self._done |= not task.goes_back and is_done(task, observation)  # observed late
            if self._done or self._tries >= MOST_TRIES:
                return _end(task, self._done, f"tried {self._tries} times")
            self._tries += 1
            self._go_on_with(task)
        return None

    def _grabbed(self, task: Task, observation: Observation, passed_s: float) -> str | None:
        self._held_s = self._held_s + passed_s if observation.pinch_n >= HELD_PINCH_N else 0.0
        if self._held_s >= HELD_S:
            return _end(task, True, "")
        if self._lasted_s > GRAB_S:
            return _end(
                task, False, f"not held after {observation.time_s - self.order.given_s:.0f} s"
            )
        return None

    def _go_on_with(self, stage: Task) -> None:
        self._stage, self._stage_s = stage, 0.0


def _tips_m(observation: Observation) -> Array:
    return observation.tips_endoscope[:, :3, 3].copy()


def _end(task: Task, done: bool, why_not: str) -> str:
    return f"Done: {task.text}." if done else f"Given up: {task.text}; {why_not}."
