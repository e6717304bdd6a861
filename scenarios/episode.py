"""One episode: the loop in which planner, controller and world meet. Read this file first.

world --Observation--> planner (1 Hz) --Instruction--> controller (a chunk at a time)
--ToolAction--> driver and safety filter (30 Hz) --JointCommand--> world --Outcome--> Step
--> observers

`scenarios/run_episode.py` sets an episode up, plays it and judges it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial

from controller.action import ToolAction
from controller.base import Controller, obeys_corrections
from controller.correction import CorrectionGuard
from controller.holding import Holding
from controller.kept_place import KeptPlace
from controller.tool_place import ToolPlace
from planner.base import PLANNING_PERIOD_S, Planner, hears_of_success
from planner.correction_way import CorrectionWay
from planner.instruction import Instruction
from planner.language.reading import Reading
from planner.person.override import PlannerOverridden
from planner.procedure.outcomes import structure_of, task_done
from planner.scene.next_task import ToolChoice
from planner.scene.predicates import is_back
from scenarios.catalogue import procedure_named
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.guarded_driver import GuardedDriver
from scenarios.loop.person.guided_arm import GuidedArm
from scenarios.loop.person.inbox import Heard, Inbox
from scenarios.loop.senses import Pictures
from scenarios.loop.step import Outcome, Step
from scenarios.loop.task_record import TaskRecord
from scenarios.loop.wall_time import ActTime, StageClock
from scenarios.perturbation.effects import Effects
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.outcome import nurse
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.sense import Sense
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World

MOST_HELD_S = 600.0  # longest hold by a person; longer: nobody is there any more; assumed
STAYS_BACK_S = 1.0  # at the end: the robot must be sure that its arm is back


@dataclass(kw_only=True)
class Episode:
    """The running state of one episode.

    Attributes:
        sense: Gives the observation to planner, controller and filter, and nothing else.
        observation: The latest observation.
        inbox: Queue of people's input to the episode.
        effects: The perturbations of the episode.
        procedure: The tasks, and what follows what.
        tasks: The record of the tasks so far.
        exchange_s: Simulated time of tool exchanges so far.
        guarded_driver: Takes actions through driver and safety filter.
        acts: Times the controller.
    """

    config: EpisodeConfig
    world: World
    planner: Planner[Observation]
    controller: Controller
    sense: Sense
    observation: Observation
    inbox: Inbox = field(default_factory=Inbox)
    effects: Effects = field(default_factory=Effects)
    exchange_s: float = 0.0

    def __post_init__(self) -> None:
        self._clock = StageClock()
        self.procedure = procedure_named(self.config.procedure)
        self.tasks = TaskRecord(self.world, self.procedure)
        self.acts = ActTime(self.config.act_limit_s)
        self.guarded_driver = GuardedDriver(
            self.world,
            self.observation.joints,
            self._clock,
            safety_filter=self.config.safety_filter,
        )
        self._tool_place, self._kept_place, self._holding = ToolPlace(), KeptPlace(), Holding()
        self._tools, self._correction_way = ToolChoice(), CorrectionWay()
        self._correction_guard = CorrectionGuard()
        self._pictures = Pictures(self.config.cameras)
        self._begun = False
        self._back_since_s = math.inf  # all is cut and the arm is back
        self._instruction = Instruction(
            task=self.procedure.tasks[0]
        )  # until the planner's first plan
        self._chunk: deque[ToolAction] = deque()
        self._guided: GuidedArm | None = None  # a person leads this arm now
        self._heard: list[Heard] = []  # observers have not received these yet
        self._told: list[str] = []
        self._held_s = 0.0  # length of the current hold by a person

    def steps(self) -> Iterator[Step]:
        """Run the loop: plan, hear, exchange tools when needed, act; until done or out of time.

        A further call, or a call on a copy, continues from the episode's current state.
        """
        if not self._begun:
            self._begin()
        while True:
            self._hear()
            while self._needs_exchange():
                yield from self._exchange()
            asked, action = self._next_action()
            command = self.guarded_driver.command(action, self._instruction, self.observation)
            step = self._step(
                command, asked=asked, disturbed=action is not asked, guided=self._guided
            )
            self.tasks.note(step, self._override.planned.task)
            yield step
            if self._is_over(step):
                return
            if self._has_news(step) or self._plan_is_due():
                self._follow(self._plan())

    @property
    def instruction(self) -> Instruction:
        """Return the instruction in force."""
        return self._instruction

    def _begin(self) -> None:
        self.controller.reset()
        self._override = PlannerOverridden(self.planner, self.procedure)
        self._override.reset()
        self._follow(self._plan())
        self._begun = True

    def _plan(self) -> Instruction:
        self._planned_s = self._time_s
        with self._clock.stage("planner"):
            stands = self.guarded_driver.standstill
            return self._override.plan(replace(self.observation, stands_still=stands))

    def _hear(self) -> None:
        """Process people's input, and the outcomes of their orders."""
        for reading in self.inbox.take(self._time_s):
            self._heard.append(self._answer(reading))
        for perturbation in self.inbox.disturbances():
            self.effects.add(perturbation)
        self._told += self._override.follow(self.observation)
        self._follow(self._override.in_force(self.observation))
        if self._tool_place.follow(self.observation, self._instruction):
            self._told.append(self._tool_place.in_words)
            self.controller.reset()
        holds, led = self._person_holds, self._led_arm
        if self._kept_place.follow(self._instruction, self._time_s, holds=holds, led=led):
            self._told += self._kept_place.in_words
            self.controller.reset()

    def _answer(self, reading: Reading) -> Heard:
        answer = self._override.hear(reading, self.observation)
        if answer.instruction is not None:
            self._kept_place.release()
        for forbidden in reading.forbids:
            self.guarded_driver.forbid(forbidden.in_words, self._time_s)
        return Heard(
            time_s=self._time_s,
            reading=reading,
            instruction=answer.instruction,
            reply=answer.reply,
        )

    def _follow(self, instruction: Instruction) -> None:
        """Adopt an instruction with its tool; a new one drops the running chunk at once."""
        if instruction.text != self._instruction.text:
            self._chunk.clear()
        tool = instruction.tool or self._tools.tool(instruction.task, self.observation)
        asked = self._correction_way.update(instruction, self.observation)
        self._instruction = replace(asked, tool=tool)

    def _has_news(self, step: Step) -> bool:
        """Return whether a task of the planner succeeded, and the planner is informed of success.

        A person's task keeps its planned time.
        """
        done = step.outcome.task_done and step.instruction.source == "planner"
        return done and hears_of_success(self.planner)

    def _plan_is_due(self) -> bool:
        return self._time_s - self._planned_s >= PLANNING_PERIOD_S - 1e-9

    def _next_action(self) -> tuple[ToolAction | None, ToolAction]:
        """Return the action that the controller requests, and the action to take.

        While the arms hold, or a perturbation leads an arm astray, the controller does not act. The
        controller starts anew afterwards.
        """
        said, jaw_rad = self._instruction, self.guarded_driver.joints[:, 6]
        if said.hold or self._person_holds:
            self.controller.reset()
            stay = self._holding.action(said, self.observation, jaw_rad, self._led_arm)
            return stay, self._guided_by_person(stay)
        self._holding.end()
        if (led := self.effects.lead(self.world, said.task)) is not None:
            self._chunk.clear()
            self.controller.reset()
            self._guided = None
            return None, led
        asked = self._correction_guard.action(
            self._kept_place.kept(self._chosen_action(), jaw_rad),
            said,
            self.observation,
            jaw_rad,
            learned=obeys_corrections(self.controller),
        )
        action = self.effects.on_action(asked, self.world, said.task)
        return asked, self._guided_by_person(action)

    def _guided_by_person(self, action: ToolAction) -> ToolAction:
        """Replace the motion of the arm that a person leads; the other arm keeps its own."""
        self._guided = self.inbox.guided
        return self._guided.lead(action, self.world) if self._guided else action

    def _chosen_action(self) -> ToolAction:
        """Return the next action of the running chunk, or the first of a new one."""
        if not self._chunk:
            with self._clock.stage("controller"):
                observation = self._pictures.added_to(self.observation, self.world)
                act = partial(self.controller.act, observation, self._instruction)
                self._chunk.extend(self.acts.timed(act))
        return self._chunk.popleft()

    def _needs_exchange(self) -> bool:
        """Return whether the nurse acts now: only while the right arm is clear of the tubes.

        No exchange begins in a hold, or while a person moves an arm, or while an arm stays in
        place.
        """
        said, seen, kept = self._instruction, self.observation, self._kept_place
        waits = said.hold or kept.moves or kept.stays
        needed = nurse.is_needed(seen, said.tool, clip=said.task.places_clip)
        return needed and not waits and nurse.has_room(seen)

    def _exchange(self) -> Iterator[Step]:
        start_s, joints = self._time_s, self.guarded_driver.joints
        self._chunk.clear()
        self._kept_place.forget()
        self._override.exchanging = True
        for command in nurse.exchange(self.world, self._instruction.tool, joints):
            self._hear()
            if self._instruction.hold:  # the rest of the exchange follows after the hold
                break
            yield self._step(command, exchange=True)
        self._hear()  # a correction that waited begins where the arm stands now
        self._override.exchanging = False
        self.guarded_driver.restart(self.world.target)
        self.controller.reset()
        self.exchange_s += self._time_s - start_s

    def _step(
        self,
        command: JointCommand,
        *,
        asked: ToolAction | None = None,
        disturbed: bool = False,
        exchange: bool = False,
        guided: GuidedArm | None = None,
    ) -> Step:
        task, n_before = self._instruction.task, len(self.world.record.injuries)
        altered, before = self.guarded_driver.news(), self.observation
        self._override.withheld = "; ".join(entry.words for entry in altered)
        heard, self._heard = tuple(self._heard), []
        told, self._told = tuple(self._told), []
        held = self._person_holds
        self._held_s = (self._held_s + CONTROL_PERIOD_S) * held
        self.effects.before_step(self.world, task)
        with self._clock.stage("world"):
            exact = self.world.step(command, intended=structure_of(task, self.world))
        with self._clock.stage("sense"):
            self.observation = self._tool_place.corrected(self.sense.observe(self.world, exact))
        return Step(
            time_s=self._time_s,
            instruction=self._instruction,
            command=command,
            before=before,
            observation=self.observation,
            exact=exact,
            outcome=Outcome(
                events=self.world.record.injuries[n_before:],
                task_done=task_done(task, self.world),
            ),
            asked=asked,
            disturbed=disturbed,
            exchange=exchange,
            held=held,
            stays=self._kept_place.stays,
            applied=self.effects.news(),
            altered=altered,
            heard=heard,
            told=told,
            guided=guided,
            ahead=tuple(self._chunk),
            spent_s=self._clock.read(),
        )

    def _is_over(self, step: Step) -> bool:
        """Return whether time is out, a person is called, or all is observed to be done.

        The last retraction ends only when the arm is back.
        """
        task, observation = step.instruction.task, step.observation
        too_long = self.tasks.results[task.index].time_s > self.config.task_cap_s
        if step.instruction.call or too_long or self._held_s > MOST_HELD_S:
            return True
        severed: dict[str, bool] = {t: observation.is_severed(t) for t in observation.tubes}
        ends = self.procedure.may_end_with(task, severed) and is_back(observation)
        self._back_since_s = min(self._back_since_s, step.time_s) if ends else math.inf
        return step.time_s - self._back_since_s >= STAYS_BACK_S - 1e-9

    @property
    def _led_arm(self) -> int | None:
        return None if self._guided is None else self._guided.arm

    @property
    def _person_holds(self) -> bool:
        return self._override.holds(self.observation)

    @property
    def _time_s(self) -> float:
        return self.observation.time_s
