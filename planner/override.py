"""A person's word comes first, for a while or until it is replaced; then the planner's again.

The planner goes on being asked all the while, so that it resumes from what it sees.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from planner.base import Planner
from planner.command import Command
from planner.correction import Correction, correction_from_text, opposite
from planner.instruction import TASKS, Instruction, Task
from planner.next_task import NotNowError, due_task
from planner.task import Tube
from tissue_sim.sensing.observation import Observation

HOLD_S = 5.0  # of simulated time, in which a person's instruction comes first
LET_GO = "open left gripper"  # the grasper's: the one that holds anything for long
STOP_WINS_S = 1.0  # after a stop: what is said so soon was meant before it


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What came of a command.

    Attributes:
        instruction: in force from now on; None where the command was refused.
        reply: in words, for the person.
    """

    instruction: Instruction | None
    reply: str


@dataclass(frozen=True, kw_only=True)
class _Said:
    """By whom it comes first.

    Attributes:
        task: None for the one that the planner is at, whichever that is by then.
        until_s: when it lapses; None when it does not by itself.
    """

    task: Task | None = None
    correction: Correction | None = None
    hold: bool = False
    confidence: float = 1.0
    given_s: float = 0.0
    until_s: float | None = None


class PlannerOverridden:
    """Says what another planner says, unless a person has said something.

    A correction is made in the course of the task in force. Stop and pause hold until something
    else is said; for a second after a stop, only to resume is heard.
    """

    def __init__(self, planner: Planner[Observation], duct: Tube = "left") -> None:
        """`duct`: the tube that people mean by it; the other one is the artery to them.

        Who names a structure has identified it, by the critical view of safety: which tube that is
        is the person's knowledge and not the planner's.
        """
        self._planner = planner
        self._duct: Tube = duct
        self._forget()

    @property
    def planned(self) -> Instruction:
        """What the planner said last, whoever is heard."""
        if self._planned is None:
            raise RuntimeError("the planner has not been asked yet")
        return self._planned

    def reset(self) -> None:
        """Forgets the episode so far, and what was said in it."""
        self._planner.reset()
        self._forget()

    def plan(self, observation: Observation) -> Instruction:
        """Asks the other planner, and returns what is in force."""
        before, self._planned = self._planned, self._planner.plan(observation)
        if self._human_at(observation.time_s) is None and (
            before is None or before.text != self._planned.text
        ):
            self._latest = _Said(task=self._planned.task, correction=self._planned.correction)
        return self.in_force(observation.time_s)

    def in_force(self, time_s: float) -> Instruction:
        """What holds at a time: a person's instruction, else what the planner said last."""
        said = self._human_at(time_s)
        if said is None:
            return self.planned
        return Instruction(
            task=said.task or self.planned.task,
            correction=said.correction,
            hold=said.hold,
            source="human",
            confidence=said.confidence,
            time_s=said.given_s,
        )

    def instruct(
        self, command: Command, observation: Observation, confidence: float = 1.0
    ) -> Answer:
        """A person's command; what is refused changes nothing."""
        now_s = observation.time_s
        try:
            said = self._said(command.seen(self._duct), observation)
        except NotNowError as refusal:
            return Answer(instruction=None, reply=f"not done: {refusal}")
        if said is None:
            return self.release(now_s)
        until_s = None if said.hold else now_s + HOLD_S
        self._human = replace(said, given_s=now_s, until_s=until_s, confidence=confidence)
        if not said.hold:
            self._latest = said
        instruction = self.in_force(now_s)
        lasts = "until something else is said" if said.hold else f"for {HOLD_S:g} s"
        return Answer(instruction=instruction, reply=f"{instruction.text}, {lasts}")

    def release(self, time_s: float) -> Answer:
        """Back to the planner."""
        self._human, self._stopped_s = None, None
        instruction = self.in_force(time_s)
        return Answer(instruction=instruction, reply=f"back to the planner: {instruction.text}")

    def _forget(self) -> None:
        self._planned: Instruction | None = None
        self._human: _Said | None = None
        self._latest = _Said()
        self._stopped_s: float | None = None

    def _human_at(self, time_s: float) -> _Said | None:
        said = self._human
        lapsed = said is None or (said.until_s is not None and time_s >= said.until_s - 1e-9)
        return None if lapsed else said

    def _said(self, command: Command, observation: Observation) -> _Said | None:
        """What a command comes to; None to go back to the planner."""
        now_s, word = observation.time_s, command.word
        if word == "resume":
            return None
        if word in ("stop", "pause"):
            self._stopped_s = now_s if word == "stop" else self._stopped_s
            return _Said(hold=True)
        if self._stopped_s is not None and now_s < self._stopped_s + STOP_WINS_S - 1e-9:
            raise NotNowError(f"it was stopped within {STOP_WINS_S:g} s; say it again, or resume")
        return self._acting(command, observation)

    def _acting(self, command: Command, observation: Observation) -> _Said:
        task = self.in_force(observation.time_s).task
        if command.task is not None:
            return _Said(task=command.task)
        if command.correction is not None:
            return self._correcting(command.correction, observation.time_s)
        if command.deed is not None and command.tube is not None:
            return _Said(task=due_task(command.deed, command.tube, observation))
        if command.word == "repeat":
            return self._latest
        if command.word == "undo":
            return self._undoing(observation.time_s)
        if command.word == "let go":
            return self._correcting(correction_from_text(LET_GO), observation.time_s)
        return _Said(task=_beside(task, 1))

    def _correcting(self, correction: Correction, time_s: float) -> _Said:
        said = self._human_at(time_s)
        return _Said(task=said.task if said else None, correction=correction)

    def _undoing(self, time_s: float) -> _Said:
        if self._latest.correction is not None:
            return replace(self._latest, correction=opposite(self._latest.correction))
        return _Said(task=_beside(self._latest.task or self.in_force(time_s).task, -1))


def _beside(task: Task, n: int) -> Task:
    """The task n places on."""
    at = TASKS.index(task) + n
    if not 0 <= at < len(TASKS):
        raise NotNowError(f"{task.text!r} is the {'last' if n > 0 else 'first'} task")
    return TASKS[at]
