"""A person's instruction replaces the planner's, for a while or until the next one.

The planner is asked all the time but in a hold, so that it resumes from what it sees.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from planner.base import Planner
from planner.command import Command
from planner.correction import Correction, correction_from_text, opposite
from planner.instruction import TASKS, Instruction, Task
from planner.seen.duct_side import duct_side
from planner.seen.next_task import NotNowError, next_task
from tissue_sim.sensing.observation import Observation

HOLD_S = 5.0  # of simulated time: how long a person's instruction stays in force
LET_GO = "open left gripper"  # the grasper: the only tool that holds tissue for long
STOP_WINS_S = 1.0  # a command this soon after a stop was meant before it, and is refused


@dataclass(frozen=True, kw_only=True)
class Answer:
    """The result of a command.

    Attributes:
        instruction: in force from now on; None if the command was refused.
        reply: in words, for the person.
    """

    instruction: Instruction | None
    reply: str


@dataclass(frozen=True, kw_only=True)
class _Order:
    """What a person has commanded.

    Attributes:
        task: None for the planner's current task at any time.
        until_s: when the command ends; None if it does not end by itself.
    """

    task: Task | None = None
    correction: Correction | None = None
    hold: bool = False
    confidence: float = 1.0
    given_s: float = 0.0
    until_s: float | None = None


class PlannerOverridden:
    """Repeats another planner's instructions, unless a person's command is in force.

    A correction is made within the task in force. Stop and pause hold until the next command; in
    the second after a stop, only "resume" is accepted.
    """

    def __init__(self, planner: Planner[Observation]) -> None:
        """Take the planner whose instructions hold where no person's does."""
        self._planner = planner
        self._forget()

    @property
    def planned(self) -> Instruction:
        """Return the planner's last instruction, even while a person's is in force."""
        if self._planned is None:
            raise RuntimeError("the planner has not been asked yet")
        return self._planned

    def reset(self) -> None:
        """Forget the episode so far and what people said in it."""
        self._planner.reset()
        self._forget()

    def plan(self, observation: Observation) -> Instruction:
        """Ask the other planner, and return the instruction in force.

        While a person holds the arms it is not asked: its clock stands still.
        """
        order = self._order_at(observation.time_s)
        if order is not None and order.hold and self._planned is not None:
            return self.in_force(observation.time_s)
        before, self._planned = self._planned, self._planner.plan(observation)
        if self._order_at(observation.time_s) is None and (
            before is None or before.text != self._planned.text
        ):
            self._latest = _Order(task=self._planned.task, correction=self._planned.correction)
        return self.in_force(observation.time_s)

    def in_force(self, time_s: float) -> Instruction:
        """Return the instruction in force: a person's, else the planner's last one."""
        order = self._order_at(time_s)
        if order is None:
            return self.planned
        return Instruction(
            task=order.task or self.planned.task,
            correction=order.correction,
            hold=order.hold,
            source="human",
            confidence=order.confidence,
            time_s=order.given_s,
        )

    def instruct(
        self, command: Command, observation: Observation, confidence: float = 1.0
    ) -> Answer:
        """Take a person's command; a refused command changes nothing."""
        now_s = observation.time_s
        try:
            order = self._interpret(command.seen(duct_side(observation)), observation)
        except NotNowError as refusal:
            return Answer(instruction=None, reply=f"not done: {refusal}")
        if order is None:
            return self.release(now_s)
        until_s = None if order.hold else now_s + HOLD_S
        self._order = replace(order, given_s=now_s, until_s=until_s, confidence=confidence)
        if not order.hold:
            self._latest = order
        instruction = self.in_force(now_s)
        lasts = "until something else is said" if order.hold else f"for {HOLD_S:g} s"
        return Answer(instruction=instruction, reply=f"{instruction.text}, {lasts}")

    def release(self, time_s: float) -> Answer:
        """Return control to the planner."""
        self._order, self._stopped_s = None, None
        instruction = self.in_force(time_s)
        return Answer(instruction=instruction, reply=f"back to the planner: {instruction.text}")

    def _forget(self) -> None:
        self._planned: Instruction | None = None
        self._order: _Order | None = None
        self._latest = _Order()
        self._stopped_s: float | None = None

    def _order_at(self, time_s: float) -> _Order | None:
        order = self._order
        lapsed = order is None or (order.until_s is not None and time_s >= order.until_s - 1e-9)
        return None if lapsed else order

    def _interpret(self, command: Command, observation: Observation) -> _Order | None:
        """Interpret a command; None returns control to the planner."""
        now_s, word = observation.time_s, command.word
        if word == "resume":
            return None
        if word in ("stop", "pause"):
            self._stopped_s = now_s if word == "stop" else self._stopped_s
            return _Order(hold=True)
        if self._stopped_s is not None and now_s < self._stopped_s + STOP_WINS_S - 1e-9:
            raise NotNowError(f"it was stopped within {STOP_WINS_S:g} s; say it again, or resume")
        return self._order_to_act(command, observation)

    def _order_to_act(self, command: Command, observation: Observation) -> _Order:
        task = self.in_force(observation.time_s).task
        if command.task is not None:
            return _Order(task=command.task)
        if command.correction is not None:
            return self._order_to_correct(command.correction, observation.time_s)
        if command.deed is not None and command.tube is not None:
            return _Order(task=next_task(command.deed, command.tube, observation))
        if command.word == "repeat":
            return self._latest
        if command.word == "undo":
            return self._order_to_undo(observation.time_s)
        if command.word == "let go":
            return self._order_to_correct(correction_from_text(LET_GO), observation.time_s)
        return _Order(task=_neighbour(task, 1))

    def _order_to_correct(self, correction: Correction, time_s: float) -> _Order:
        order = self._order_at(time_s)
        return _Order(task=order.task if order else None, correction=correction)

    def _order_to_undo(self, time_s: float) -> _Order:
        if self._latest.correction is not None:
            return replace(self._latest, correction=opposite(self._latest.correction))
        return _Order(task=_neighbour(self._latest.task or self.in_force(time_s).task, -1))


def _neighbour(task: Task, n: int) -> Task:
    """Return the task n places further in the procedure."""
    at = TASKS.index(task) + n
    if not 0 <= at < len(TASKS):
        raise NotNowError(f"{task.text!r} is the {'last' if n > 0 else 'first'} task")
    return TASKS[at]
