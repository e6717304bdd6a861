"""Describe the losses that an order would cause, and keep a person's confirmation."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from planner.correction import Correction
from planner.language.reading import Reading, Said
from planner.person.orders import Order
from planner.person.premises import Claim, denial
from planner.person.prohibition import (
    Prohibition,
    act_of,
    already_so,
    unmeant_by,
    unmeant_in_words,
)
from planner.person.standing import Standing
from planner.procedure.procedure import Procedure
from planner.procedure.task import Task
from planner.scene.next_task import NotNowError
from planner.scene.predicates import pulls
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import HELD_PINCH_N

YES_S = 30.0  # a yes that comes later after a question is no answer to it; assumed


class ConfirmError(NotNowError):
    """A person must confirm first; the message describes the loss."""


class Confirmation:
    """Keeps the order that a person may confirm, from the robot's question to the next word.

    Attributes:
        given: Whether the present words confirm an order, after the robot named the loss or error.
    """

    def __init__(self) -> None:
        self._asked: Reading | None = None
        self._told = False
        self._asked_s = 0.0
        self._unmeant: Prohibition | None = None  # the act due as another act was forbidden
        self.given = False

    @property
    def guess(self) -> Said | None:
        """Return the command whose meaning the robot has asked about; None if there is none."""
        return self._asked.said[0] if self._asked is not None and not self._told else None

    def offer(self, guesses: Sequence[Said], time_s: float) -> None:
        """Keep a single guess at the meaning, which the robot asks about."""
        if len(guesses) == 1:
            self._ask(reading_of(guesses), time_s, told=False)

    def ask_all_the_same(self, reading: Reading, time_s: float) -> str:
        """Return the question whether to act all the same; "" if no act was requested."""
        acts = [said.text for said in reading.said]
        if reading.allows is not None:
            acts.append(f"allow {reading.allows.in_words}")
        if not acts:
            return ""
        self._ask(reading, time_s)
        return f' Say "yes" to do it all the same: {", then ".join(acts)}.'

    def ask_to_allow(self, act: Prohibition, observation: Observation) -> str:
        """Return the question whether a person allows an act, forbidden until the answer."""
        words = act.seen(observation).in_words
        self._ask(Reading(text=words, allows=act, by="rule", reply=""), observation.time_s)
        return f'Do you allow: {words}? Say "yes" to allow it. It is forbidden still.'

    def remarks(
        self,
        bans: Collection[Prohibition],
        standing: Standing,
        task: Task,
        observation: Observation,
    ) -> tuple[str, ...]:
        """Return in words the bans that come too late, and the act that was due instead."""
        if not bans:
            return ()
        due = unmeant_by(bans, task, observation)
        self._unmeant = due = None if due is None or standing.forbids(due) else due
        late = tuple(filter(None, (already_so(ban, observation) for ban in bans)))
        return (*late, unmeant_in_words(bans, due, observation)) if due else late

    def require_meant(self, standing: Standing, task: Task, observation: Observation) -> None:
        """Require a confirmation of the due act, if a person forbade another act meanwhile.

        Raises:
            ConfirmError: The act is still due, and the person has not confirmed it.
        """
        due, self._unmeant = self._unmeant, None
        if due is None or self.given or standing.forbids(due) or act_of(task, observation) != due:
            return
        self._unmeant = due
        forbidden = ", ".join(standing.listed(observation))
        raise ConfirmError(f"You forbade: {forbidden}. If I go on, I {due.act} the {due.on}.")

    def answered(self, reading: Reading, time_s: float) -> Reading:
        """Return the reading of a person's words: for a yes, the reading that it confirms."""
        asked, self._asked = self._asked, None
        in_time = time_s <= self._asked_s + YES_S
        agreed = asked if in_time and (reading.agrees or _goes_on(reading, asked)) else None
        self.given = agreed is not None and self._told
        self.offer(reading.guesses, time_s)
        return agreed or reading

    def _ask(self, reading: Reading, time_s: float, *, told: bool = True) -> None:
        self._asked, self._asked_s, self._told = reading, time_s, told


def reading_of(said: Sequence[Said]) -> Reading:
    """Return the reading of commands, the first of which waits for a confirmation."""
    first, *then = said
    return Reading(
        text=first.text,
        command=first.command,
        size_m=first.size_m,
        side=first.side,
        relative=first.relative,
        then=tuple(then),
        confidence=1.0,
        by="rule",
        reply="",
    )


def loss(order: Order, skipped: Task | None, observation: Observation) -> str:
    """Return in words the loss that an order would cause, by observation; "" if there is none.

    Args:
        order: The order that a person has given.
        skipped: The task in force, where the order is to go on to the next task.
        observation: The present observation.
    """
    if order.correction is not None:
        return _let_go(order.correction, observation)
    undone = not_done(skipped, observation) if skipped else ""
    return f"{undone} The next step leaves it so." if undone else ""


def not_done(task: Task, observation: Observation) -> str:
    """Return in words the missing part of a grab, clip or cut; "" if done, or for a retraction."""
    if task.grasps:
        return (
            "" if pulls(observation) else "The grasper does not yet hold the gallbladder and pull."
        )
    if not task.is_deed:
        return ""
    return denial((Claim(claimed="cut" if task.severs else "clip on"),), task, observation)


def lacking(task: Task, observation: Observation, procedure: Procedure) -> str:
    """Return in words what lacks before a cut or a retraction, by observation; "" if nothing."""
    if task.goes_back:
        deed = procedure.before(task) if procedure.holds(task.index - 1) else task
        return not_done(deed, observation)
    unclipped = task.severs and denial((Claim(claimed="clipped"),), task, observation)
    return f"{unclipped} The safety filter lets nothing be cut before." if unclipped else ""


def _let_go(correction: Correction, observation: Observation) -> str:
    opens = correction.jaw == "open" and correction.arm in ("left", "both")
    if not opens or observation.pinch_n < HELD_PINCH_N or observation.all_severed:
        return ""
    return "The left gripper holds the gallbladder: opening lets it go, and the tubes slacken."


def _goes_on(reading: Reading, asked: Reading | None) -> bool:
    """Return whether a person repeats the order to go on, where that was the question."""
    resumes = reading.command is not None and reading.command.word == "resume"
    return resumes and asked is not None and asked.command == reading.command
