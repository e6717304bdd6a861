"""What would be lost by an order, and who says yes to it all the same."""

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
from planner.scene.next_task import NotNowError
from planner.scene.predicates import pulls
from planner.task import TASKS, Task
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import HELD_PINCH_N

YES_S = 30.0  # a yes that comes later after a question is no answer to it; assumed


class ConfirmError(NotNowError):
    """A person must say yes first; the message says what would be lost."""


class Confirmation:
    """Keeps what a person may say yes to, from the robot's question to the next word.

    Attributes:
        given: what is said now is the yes of a person who was told what would be lost, or is wrong.
    """

    def __init__(self) -> None:
        self._asked: Reading | None = None
        self._told = False
        self._asked_s = 0.0
        self._unmeant: Prohibition | None = None  # what was due as something else was forbidden
        self.given = False

    @property
    def guess(self) -> Said | None:
        """Return what the robot has asked whether it was meant; None if nothing."""
        return self._asked.said[0] if self._asked is not None and not self._told else None

    def offer(self, guesses: Sequence[Said], time_s: float) -> None:
        """Keep the only guess at what was meant, which the robot asks about."""
        if len(guesses) == 1:
            self._ask(reading_of(guesses), time_s, told=False)

    def ask_all_the_same(self, reading: Reading, time_s: float) -> str:
        """Ask whether to do what was said all the same; "" if nothing was to be done."""
        acts = [said.text for said in reading.said]
        if reading.allows is not None:
            acts.append(f"allow {reading.allows.in_words}")
        if not acts:
            return ""
        self._ask(reading, time_s)
        return f' Say "yes" to do it all the same: {", then ".join(acts)}.'

    def ask_to_allow(self, act: Prohibition, seen: Observation) -> str:
        """Ask whether a person allows what may be meant; it stays forbidden until the answer."""
        words = act.seen(seen).in_words
        self._ask(Reading(text=words, allows=act, by="rule", reply=""), seen.time_s)
        return f'Do you allow: {words}? Say "yes" to allow it. It is forbidden still.'

    def remarks(
        self, bans: Collection[Prohibition], standing: Standing, task: Task, seen: Observation
    ) -> tuple[str, ...]:
        """Return which bans come too late, and what was about to be done instead."""
        if not bans:
            return ()
        due = unmeant_by(bans, task, seen)
        self._unmeant = due = None if due is None or standing.forbids(due) else due
        late = tuple(filter(None, (already_so(ban, seen) for ban in bans)))
        return (*late, unmeant_in_words(bans, due, seen)) if due else late

    def require_meant(self, standing: Standing, task: Task, seen: Observation) -> None:
        """Ask before what was due is done, if a person forbade something else as it was due.

        Raises:
            ConfirmError: it is due still, and the person has not said yes to it.
        """
        due, self._unmeant = self._unmeant, None
        if due is None or self.given or standing.forbids(due) or act_of(task, seen) != due:
            return
        self._unmeant = due
        forbidden = ", ".join(sorted(ban.in_words for ban in standing.forbidden))
        raise ConfirmError(f"You forbade: {forbidden}. If I go on, I {due.act} the {due.on}.")

    def answered(self, reading: Reading, time_s: float) -> Reading:
        """Return what a person says: of a yes, what it agrees to; of any other word, that word."""
        asked, self._asked = self._asked, None
        in_time = time_s <= self._asked_s + YES_S
        agreed = asked if in_time and (reading.agrees or _goes_on(reading, asked)) else None
        self.given = agreed is not None and self._told
        self.offer(reading.guesses, time_s)
        return agreed or reading

    def _ask(self, reading: Reading, time_s: float, *, told: bool = True) -> None:
        self._asked, self._asked_s, self._told = reading, time_s, told


def reading_of(said: Sequence[Said]) -> Reading:
    """Return the reading of commands, the first of which waits for a yes."""
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


def loss(order: Order, skipped: Task | None, seen: Observation) -> str:
    """Return what would be lost by an order, as far as it is seen; "" if nothing would be.

    Args:
        order: that a person has given.
        skipped: the task in force, where the order is to go on to the next one.
        seen: now.
    """
    if order.correction is not None:
        return _let_go(order.correction, seen)
    undone = not_done(skipped, seen) if skipped else ""
    return f"{undone} The next step leaves it so." if undone else ""


def not_done(task: Task, seen: Observation) -> str:
    """Return what of a grab, a clip or a cut is not seen to be done; "" if it is, or goes back."""
    if task.kind == "grab":
        return "" if pulls(seen) else "The grasper does not yet hold the gallbladder and pull."
    if task.goes_back:
        return ""
    return denial((Claim(claimed="cut" if task.kind == "cut" else "clip on"),), task, seen)


def lacking(task: Task, seen: Observation) -> str:
    """Return what is not seen that should come before a cut or a way back; "" if nothing."""
    if task.goes_back:
        return not_done(TASKS[task.index - 2], seen)
    unclipped = task.kind == "cut" and denial((Claim(claimed="clipped"),), task, seen)
    return f"{unclipped} The safety filter lets nothing be cut before." if unclipped else ""


def _let_go(correction: Correction, seen: Observation) -> str:
    opens = correction.jaw == "open" and correction.arm in ("left", "both")
    if not opens or seen.pinch_n < HELD_PINCH_N or seen.severed.all():
        return ""
    return "The left gripper holds the gallbladder: opening lets it go, and the tubes slacken."


def _goes_on(reading: Reading, asked: Reading | None) -> bool:
    """Return whether a person says once more to go on, where that was the question."""
    resumes = reading.command is not None and reading.command.word == "resume"
    return resumes and asked is not None and asked.command == reading.command
