"""Put a person's words before the planner's: warnings, orders, prohibitions, questions.

The planner is asked all the time, so that it resumes from the present observation. The exceptions
are a hold, an ordered task, and a planned act that a person forbade.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from planner.base import Planner, require_instruction
from planner.command import COMMANDS, Command
from planner.instruction import Instruction, Task
from planner.language.reading import Reading, Said
from planner.person.answers import answer, doing_in_words
from planner.person.applier_order import choice_in_words, chosen_applier, tube_meant
from planner.person.confirmation import Confirmation, ConfirmError, lacking, loss, reading_of
from planner.person.interpretation import Moment, acts_of, order_of
from planner.person.orders import Order, OrderProgress
from planner.person.premises import denial
from planner.person.standing import Standing
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.procedure import Procedure
from planner.rules.anatomy_gate import AnatomyGate
from planner.scene.next_task import DoneAlreadyError, NotNowError
from planner.scene.predicates import is_back
from tissue_sim.sensing.observation import Observation

STOP_WINS_S = 1.0  # a command this soon after a stop was meant before the stop, and is refused
ASK_S, ASK_AGAIN_S = 5.0, 30.0  # of a hold by a warning, before the robot asks to go on; assumed


@dataclass(frozen=True, kw_only=True)
class Answer:
    """The result of a person's words.

    Attributes:
        instruction: Instruction in force from now on; None if the words change nothing.
        reply: Reply to the person in words; its last sentence describes the arms' present action.
        refusal: Reason why an understood command is not carried out; None if it is carried out.
    """

    instruction: Instruction | None
    reply: str
    refusal: NotNowError | None = None


class PlannerOverridden:
    """Repeats another planner's instructions, unless a person's order is in force.

    A correction is made within the task in force; a correction in a hold ends in the hold. Stop and
    pause hold until a task is ordered, or "resume". In the second after a stop, only "resume" is
    accepted. A warning holds, too; after a while the robot asks whether the hold was meant.
    A forbidden act is not done until a person allows it; where the act is due, the arms hold.

    Attributes:
        exchanging: Whether the nurse has the right arm, so that orders wait.
        withheld: Reason why the safety filter altered the last command; "" if it did not.
    """

    def __init__(
        self, planner: Planner[Observation], procedure: Procedure = CHOLECYSTECTOMY
    ) -> None:
        """Take the planner whose instructions are in force where no person's is."""
        self._planner, self._procedure = planner, procedure
        self._forget()

    @property
    def planned(self) -> Instruction:
        """Return the planner's last instruction, even while a person's is in force."""
        if self._planned is None:
            raise RuntimeError("the planner has not been asked yet")
        return self._planned

    def reset(self) -> None:
        """Forget the episode so far, with all words of people."""
        self._planner.reset()
        self._forget()

    def plan(self, observation: Observation) -> Instruction:
        """Ask the other planner, and return the instruction in force.

        The planner is not asked while a person holds the arms, has ordered a task, or has forbidden
        the planned act. Meanwhile, and while a tool is exchanged, the planner's clock stands still.
        If arms are to move slower, the planner's time also runs slower.
        """
        self._run_clock(observation)
        if self._rests(observation):
            return self.in_force(observation)
        before, self._planned = self._planned, self._asked(observation)
        if self._progress is None and (before is None or before.text != self._planned.text):
            self._latest = Order(task=self._planned.task, correction=self._planned.correction)
        return self.in_force(observation)

    def follow(self, observation: Observation) -> Sequence[str]:
        """Take in one control step; return messages for the person, as on orders that ended."""
        self._run_clock(observation)
        told, self._untold = [*self._untold, *self._asks_to_go_on(observation)], []
        told += self._barred_now(observation)
        progress = self._progress
        self._note_way(observation)
        ended = progress and progress.update(
            observation,
            exchanging=self.exchanging,
            speed=self.standing.speed,
            forbidden=self.in_force(observation).forbidden,
            withheld=self.withheld,
        )
        if ended:
            again = self._hold_after
            self._progress = None
            told += [ended, *self._begin_next(observation)]
            if self._progress is None and again:
                self._begin(Order(hold=True), observation, 1.0)
            elif self._progress is None and self._interrupted is not None:
                self._progress, self._then = self._interrupted
                self._interrupted = None
                self._progress.go_on(observation.time_s)
        return tuple(f"{remark} {self._doing(observation)}" for remark in told)

    def in_force(self, observation: Observation) -> Instruction:
        """Return the instruction in force: a person's, else the planner's last one."""
        asked = self._ordered(observation) or self.planned
        return self.standing.applied_to(asked, observation)

    def holds(self, observation: Observation) -> bool:
        """Return whether a person lets the arms hold; an arm corrected in a hold moves alone."""
        corrects = self._progress is not None and self._progress.order.correction is not None
        task = (self._progress and self._progress.task) or self.planned.task
        by_ban = self.standing.forbidden_in(task, observation) is not None
        return self._held or self._hold_after or by_ban or (corrects and self.planned.hold)

    def hear(self, reading: Reading, observation: Observation) -> Answer:
        """Take in a person's words; the reply describes the result."""
        offered = self._confirmation.guess
        reading = self._confirmation.answered(reading, observation.time_s)
        may_lift = reading.may_allow and self.standing.covered_by(reading.may_allow, observation)
        self.standing.forbid(reading.forbids, observation)
        if reading.speed:
            return self._told_speed(reading, observation)
        if reading.applier:
            return self._told_applier(reading, observation)
        if reading.question is not None:
            now = self.in_force(observation)
            said = answer(
                reading.question,
                now,
                observation,
                reading.about,
                reading.claims,
                self._procedure,
            )
            return Answer(instruction=None, reply=f"{said} {self._doing(observation)}")
        if wrong := denial(reading.claims, self.in_force(observation).task, observation):
            return self._contradicted(wrong, replace(reading, claims=()), observation)
        if reading.may_allow and may_lift:
            asked = self._confirmation.ask_to_allow(reading.may_allow, observation)
            return Answer(instruction=None, reply=f"{asked} {self._doing(observation)}")
        if reading.allows and (told := self.standing.allow(reading.allows, observation)):
            how = ' Say "resume" to go on.' if self._held else ""
            reply = f"{told}{how} {self._doing(observation)}"
            return Answer(instruction=self.in_force(observation), reply=reply)
        if reading.command is None:
            reply = "I see it so, too." if reading.claims and not reading.guesses else reading.reply
            return Answer(instruction=None, reply=f"{reply} {self._doing(observation)}")
        task = self.in_force(observation).task
        remarks = self._confirmation.remarks(reading.forbids, self.standing, task, observation)
        given = self._obey(reading.said, observation, reading.confidence)
        if given.instruction is None or (reading.by != "warning" and not reading.forbids):
            return given
        denies = offered is not None and offered.command.word == "resume"  # "Go on?" "No."
        self._ask_s = math.inf if denies else observation.time_s + ASK_S
        return replace(given, reply=" ".join((reading.reply, *remarks, self._doing(observation))))

    def instruct(
        self,
        command: Command,
        observation: Observation,
        confidence: float = 1.0,
        size_m: float | None = None,
    ) -> Answer:
        """Take a person's command; a refused command changes nothing."""
        return self._obey((Said(command=command, size_m=size_m),), observation, confidence)

    def _obey(self, said: Sequence[Said], observation: Observation, confidence: float) -> Answer:
        """Begin the first of some commands; the others follow."""
        first, *then = said
        try:
            order = self._interpret(first, observation)
        except ConfirmError as lost:
            ask = self._confirmation.ask_all_the_same(reading_of(said), observation.time_s)
            reply = f"{lost}{ask} {self._doing(observation)}"
            return Answer(instruction=None, reply=reply, refusal=ConfirmError(f"{lost}{ask}"))
        except NotNowError as refusal:
            after = f"; nor what was to follow: {_in_order(then)}" if then else ""
            reply = f"Not done: {refusal}{after}. {self._doing(observation)}"
            return Answer(instruction=None, reply=reply, refusal=refusal)
        if order is None:
            return self.release(observation)
        self._interrupt(order, observation)
        self._then = deque(then)
        self._hold_after = order.correction is not None and (self._held or self._hold_after)
        self._begin(order, observation, confidence)
        instruction = self.in_force(observation)
        if order.hold:
            return Answer(
                instruction=instruction, reply=f"I hold, {order.lasts(self.standing.speed)}."
            )
        after = f", then {_in_order(then)}" if then else ""
        what, lasts = order_in_words(order, instruction), order.lasts(self.standing.speed)
        waits = ", once the tool is exchanged" if self.exchanging and order.correction else ""
        reply = f"{what}, {lasts}{waits}{after}."
        return Answer(instruction=instruction, reply=f"{reply} {self._doing(observation)}")

    def release(self, observation: Observation) -> Answer:
        """Return control to the planner."""
        self._interrupt(Order(hold=True), observation)
        self._progress, self._stopped_s, self._hold_after = None, None, False
        instruction = self.in_force(observation)
        self._barred = instruction.remark if instruction.hold else ""
        why = f" {self._barred}" if self._barred else ""
        reply = f"Back to the planner.{why} {doing_in_words(instruction)}"
        return Answer(instruction=instruction, reply=reply)

    def _asked(self, observation: Observation) -> Instruction:
        """Return the planner's instruction for an observation, at the time of its own clock."""
        if self._late_s == 0.0:
            return require_instruction(self._planner.plan(observation))
        by_its_clock = replace(observation, time_s=observation.time_s - self._late_s)
        planned = require_instruction(self._planner.plan(by_its_clock))
        return replace(planned, time_s=planned.time_s + self._late_s)

    def _run_clock(self, observation: Observation) -> None:
        """Let the planner's clock run since the last call, as fast as its task is carried out."""
        passed_s, self._seen_s = observation.time_s - self._seen_s, observation.time_s
        stands = self.exchanging or self._rests(observation)
        self._late_s += passed_s if stands else (1.0 - self.standing.speed) * passed_s

    def _rests(self, observation: Observation) -> bool:
        """Return whether the planner is not asked, because its instruction is not followed now."""
        if self._planned is None:
            return False
        ordered = self._progress is not None and self._progress.task is not None
        return ordered or self.holds(observation)

    def _asks_to_go_on(self, observation: Observation) -> Sequence[str]:
        """Return the due question whether a warning was meant to hold the arms, if any."""
        if not self._held or observation.time_s < self._ask_s:
            return ()
        self._ask_s = observation.time_s + ASK_AGAIN_S
        guess = self._confirmation.guess
        if guess is not None and guess.command.word != "resume":
            return (f'Did you mean "{guess.text}"? To go on say "resume".',)
        self._confirmation.offer((Said(command=COMMANDS["resume"]),), observation.time_s)
        return ('Go on? Say "yes" or "resume".',)

    def _barred_now(self, observation: Observation) -> Sequence[str]:
        """Return in words the ban that lets the arms hold, as the hold begins or begins again."""
        now = self.in_force(observation) if self.standing.forbidden else None
        barred = now.remark if now is not None and now.hold and not self._held else ""
        news, self._barred = barred != self._barred, barred
        return (barred,) if barred and news else ()

    @property
    def _held(self) -> bool:
        return self._progress is not None and self._progress.order.hold

    def _forget(self) -> None:
        self._planned: Instruction | None = None
        self._seen_s, self._late_s = 0.0, 0.0  # of the planner's clock
        self._progress: OrderProgress | None = None
        self._then = deque[Said]()
        self._interrupted: tuple[OrderProgress, deque[Said]] | None = None
        self._untold: list[str] = []  # messages on orders that are still to be sent
        self._hold_after = False  # a correction in a hold ends in it
        self.exchanging, self.withheld = False, ""
        self._ask_s = math.inf  # when to ask whether to go on
        self._latest, self._corrected = Order(), None
        self._gone_m: float | None = None  # the way of the latest correction
        self._stopped_s: float | None = None
        self._confirmation = Confirmation()
        self._barred = ""  # the ban that lets the arms hold, as reported to the person
        self._room = AnatomyGate()
        self.standing = Standing()

    def _doing(self, observation: Observation) -> str:
        return doing_in_words(self.in_force(observation))

    def _ordered(self, observation: Observation) -> Instruction | None:
        if self._progress is None:
            return None
        order, planned = self._progress.order, self.planned
        task = self._progress.task or planned.task
        return Instruction(
            task=task,
            tool=planned.tool if task == planned.task else "",
            correction=order.correction,
            hold=order.hold,
            source="human",
            confidence=order.confidence,
            time_s=order.given_s,
            left_m=self._progress.left_m(observation),
        )

    def _interrupt(self, order: Order, observation: Observation) -> None:
        """Keep an ordered task for after a correction; report the progress of other ended orders.

        Orders that follow a task are kept with the task. Orders that follow a correction are
        dropped. Their place may be another one now, and a clip or a cut there cannot be undone.
        """
        if self._progress is not None and self._progress.is_task:
            self._interrupted = self._progress, self._then
        else:
            if self._progress is not None:
                self._tell(self._progress.cut_short(observation))
            self._drop(self._then)
        if order.correction is None and self._interrupted is not None:
            progress, then = self._interrupted
            self._tell(progress.cut_short(observation))
            self._drop(then)
            self._interrupted = None
        self._then = deque[Said]()

    def _tell(self, remark: str) -> None:
        if remark:
            self._untold.append(remark)

    def _drop(self, then: deque[Said]) -> None:
        if then:
            self._untold.append(f"Not done: {_in_order(then)}; something else was said.")

    def _begin(self, order: Order, observation: Observation, confidence: float) -> None:
        now = replace(order, given_s=observation.time_s, confidence=confidence)
        leaving = self._leaving(order, observation)
        self._progress = OrderProgress(now, observation, self._procedure, leaving)
        self._ask_s = math.inf
        if not order.hold:
            self._latest = order
            self._corrected = order if order.correction else None
        self._doubt(order, observation)

    def _doubt(self, order: Order, observation: Observation) -> None:
        """Report missing steps before an ordered retraction, clip or cut, and doubts about it."""
        if order.correction or order.task is None or order.hold:
            return
        self._tell(lacking(order.task, observation, self._procedure))
        if not order.task.is_deed:
            return
        if (why := self._room.why_call(observation, due=True)) is not None:
            self._untold.append(f"I would have called for a person. {why}")

    def _leaving(self, order: Order, observation: Observation) -> Task | None:
        """Return the retraction that must come first, as policies do not start among tissue."""
        present, task = self.in_force(observation).task, order.task
        among = present.tube is not None and not is_back(observation)
        if task is None or task.tube is None or task.goes_back or order.correction or not among:
            return None
        back = present if present.goes_back else self._procedure.retraction_after(present)
        return None if present == task else back

    def _begin_next(self, observation: Observation) -> Sequence[str]:
        """Begin the orders that follow an order; return in words the dropped ones, with reasons.

        Finished orders are passed over. If an order cannot be carried out now, all orders that
        follow it are dropped.
        """
        told, rest = list[str](), self._then
        self._then, self._confirmation.given = deque[Said](), False
        while rest:
            given = self._obey(tuple(rest), observation, 1.0)
            said = rest.popleft()
            if given.refusal is None:
                break
            if isinstance(given.refusal, ConfirmError):
                told.append(str(given.refusal))
                break
            passed_over = isinstance(given.refusal, DoneAlreadyError)
            dropped = (said,) if passed_over else (said, *rest)
            told.append(f"Not done: {_in_order(dropped)}; {given.refusal}.")
            if not passed_over:
                break
        return told

    def _told_speed(self, reading: Reading, observation: Observation) -> Answer:
        """Take in words about speed, and further requests; the answer names both."""
        self.standing.set_speed(reading.speed)
        speed = f"Speed {self.standing.speed:.0%} of the usual."
        if reading.command is not None:
            given = self.hear(replace(reading, speed=""), observation)
            instruction = given.instruction or self.in_force(observation)
            return Answer(instruction=instruction, reply=f"{speed} {given.reply}")
        remark = f"{reading.reply} " if reading.by == "nobody" else ""
        reply = f"{speed} {remark}{self._doing(observation)}"
        return Answer(instruction=self.in_force(observation), reply=reply)

    def _told_applier(self, reading: Reading, observation: Observation) -> Answer:
        """Take in the choice of a clip applier, and further requests; the answer names both."""
        assert reading.applier is not None, "an applier was chosen"
        try:
            tube = tube_meant(reading, self.in_force(observation).task, observation)
            applier = chosen_applier(reading.applier, tube, observation)
        except NotNowError as refusal:
            after = f"; nor what was to follow: {_in_order(reading.said)}" if reading.said else ""
            reply = f"Not done: {refusal}{after}. {self._doing(observation)}"
            return Answer(instruction=None, reply=reply, refusal=refusal)
        self.standing.appliers[tube] = applier.name
        told = choice_in_words(applier, tube, observation)
        if reading.command is not None:
            given = self.hear(replace(reading, applier=None), observation)
            return replace(given, reply=f"{told} {given.reply}")
        reply = f"{told} {self._doing(observation)}"
        return Answer(instruction=self.in_force(observation), reply=reply)

    def _interpret(self, said: Said, observation: Observation) -> Order | None:
        """Interpret a command; None returns control to the planner."""
        now_s, word = observation.time_s, said.command.word
        if word == "resume":
            self._confirmation.require_meant(self.standing, self.planned.task, observation)
            return None
        if word in ("stop", "pause"):
            self._stopped_s = now_s if word == "stop" else self._stopped_s
            return Order(hold=True)
        if self._stopped_s is not None and now_s < self._stopped_s + STOP_WINS_S - 1e-9:
            raise NotNowError(f"it was stopped within {STOP_WINS_S:g} s; say it again, or resume")
        moment = self._moment(observation)
        order = order_of(said, moment)
        if order.task is not None:
            order = replace(order, task=self._own(order.task))
        for act in acts_of(order, observation):
            if self.standing.forbids(act):
                raise NotNowError(f'you forbade it; to allow it say "you may {act.in_words}"')
        skipped = moment.task if word == "next step" else None
        if not self._confirmation.given and (lost := loss(order, skipped, observation)):
            raise ConfirmError(lost)
        return order

    def _own(self, task: Task) -> Task:
        """Return the procedure's own task that a person means.

        Raises:
            NotNowError: The procedure has no such task.
        """
        if (own := self._procedure.like(task)) is None:
            raise NotNowError(f"{self._procedure.name} has no task {task.text!r}")
        return own

    def _contradicted(self, wrong: str, reading: Reading, observation: Observation) -> Answer:
        """Answer a person with a wrong claim: hold if a hold was said, and else ask back."""
        if reading.command is not None and not reading.command.moves:
            given = self.hear(reading, observation)
            return replace(given, reply=f"{wrong} {given.reply}")
        ask = self._confirmation.ask_all_the_same(reading, observation.time_s)
        if reading.guesses:
            ask = f" {reading.reply}"
        return Answer(instruction=None, reply=f"{wrong}{ask} {self._doing(observation)}")

    def _note_way(self, observation: Observation) -> None:
        if self._progress is not None and self._progress.order.correction is not None:
            self._gone_m = self._progress.gone_m(observation)

    def _moment(self, observation: Observation) -> Moment:
        self._note_way(observation)
        ordered = None if self._progress is None or self._held else self._progress.task
        task = self.in_force(observation).task
        return Moment(
            observation=observation,
            task=task,
            ordered=ordered,
            latest=self._latest,
            corrected=self._corrected,
            gone_m=self._gone_m if self._latest is self._corrected else None,
            procedure=self._procedure,
        )


def order_in_words(order: Order, instruction: Instruction) -> str:
    """Return an order in the words of an instruction."""
    return order.correction.text if order.correction else (order.task or instruction.task).text


def _in_order(said: Iterable[Said]) -> str:
    return ", then ".join(one.text for one in said)
