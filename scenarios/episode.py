"""One episode: the loop in which planner, controller and world meet. Read this file first.

world --Observation--> planner (1 Hz) --Instruction--> controller (a chunk at a time)
--ToolAction--> driver and safety filter (30 Hz) --JointCommand--> world --Outcome--> Step
--> observers
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from pkgutil import resolve_name

from controller.action import Chunk, ToolAction, hold
from controller.base import Controller
from controller.driver import Driver, Rig, rig_of
from controller.safety.filter import SafetyFilter
from controller.safety.ledger import Entry
from planner.base import PLANNING_PERIOD_S, Planner
from planner.criteria import structure_of, task_done
from planner.instruction import TASKS, Instruction, Source
from planner.language.interpreter import Reading
from planner.override import Answer, PlannerOverridden
from planner.task import Task, Tube
from scenarios.catalogue import (
    ABLATIONS,
    CONTROLLERS,
    ENDPOINT_PLANNERS,
    LEARNED_CONTROLLERS,
    LEARNED_PLANNERS,
    PLANNERS,
    SCENARIOS,
)
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.guided_arm import GuidedArm
from scenarios.loop.inbox import Heard, Inbox
from scenarios.loop.motion_metrics import MotionMetrics
from scenarios.loop.observer import Observer
from scenarios.loop.results import EpisodeResult, InjuryResult, SafetyResult, TaskResult
from scenarios.loop.script import read_script
from scenarios.loop.stage_clock import StageClock
from scenarios.perturbation.effect import Applied
from scenarios.perturbation.effects import Effects
from tissue_sim.frames import Array
from tissue_sim.outcome import nurse
from tissue_sim.outcome.predicates import right_arm_back, stumps_hold, tube_severed
from tissue_sim.outcome.retention import pull_all_clips
from tissue_sim.patient.anatomy import Anatomy, anatomy_from_seed
from tissue_sim.patient.organ import TUBES
from tissue_sim.patient.variants import variant
from tissue_sim.sensing.observation import Observation
from tissue_sim.surgery.injury import Injury
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World


def run_episode(
    config: EpisodeConfig, observers: Sequence[Observer] = (), inbox: Inbox | None = None
) -> EpisodeResult:
    """Run one episode to its end and judge it; `inbox` is where people speak to it.

    An exception ends the episode and is the caller's to record: it is no failed episode.
    """
    start_s = time.perf_counter()
    render = any(getattr(o, "needs_images", False) for o in observers)
    episode = begin(config, render=render, inbox=inbox)
    return play(episode, observers, start_s)


def play(episode: Episode, observers: Sequence[Observer], start_s: float) -> EpisodeResult:
    """From where it has begun, at `start_s` of `perf_counter`, to its end."""
    for observer in observers:
        observer.on_reset(episode.world)
    conduct = MotionMetrics(episode.world)
    for step in episode.steps():
        conduct.on_step(step)
        for observer in observers:
            observer.on_step(step)
    result = result_of(episode, start_s)
    result = replace(result, tasks=conduct.measured(result.tasks))
    for observer in observers:
        observer.on_end(result)
    return result


def begin(config: EpisodeConfig, *, render: bool = False, inbox: Inbox | None = None) -> Episode:
    """The patient on the table, planner and controller ready, nothing done yet."""
    inbox = inbox or Inbox()
    if config.instruct is not None:
        inbox.arrange(read_script(Path(config.instruct)))
    world, effects = World(render=render), Effects(config.perturbations, config.seed)
    observation = world.reset(effects.on_anatomy(anatomy_of(config)))
    return Episode(
        world=world,
        planner=_planner(config, world),
        controller=_controller(config, world),
        inbox=inbox,
        effects=effects,
        observation=observation,
        config=config,
    )


def _planner(config: EpisodeConfig, world: World) -> Planner[Observation]:
    whole = _whole_planner(config, world)
    return whole if config.ablation is None else resolve_name(ABLATIONS[config.ablation])(whole)


def _whole_planner(config: EpisodeConfig, world: World) -> Planner[Observation]:
    make = resolve_name(PLANNERS[config.planner])
    if config.planner in ENDPOINT_PLANNERS:
        return make()
    return make(config.planner_checkpoint if config.planner in LEARNED_PLANNERS else world)


def _controller(config: EpisodeConfig, world: World) -> Controller:
    make = resolve_name(CONTROLLERS[config.controller])
    if config.controller in LEARNED_CONTROLLERS:
        return make(config.checkpoint, config.seed)
    return make(world)


def anatomy_of(config: EpisodeConfig) -> Anatomy:
    """The seed's patient, with the scenario's anatomical variant."""
    anatomy, name = anatomy_from_seed(config.seed), SCENARIOS[config.scenario].variant
    return variant(name, anatomy) if name else anatomy


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a step did to the patient, and whether the running task's criterion is met."""

    events: tuple[Injury, ...]
    task_done: bool


@dataclass(frozen=True, kw_only=True)
class Step:
    """One control step, as observers see it.

    Attributes:
        observation: After the command.
        asked: What the controller asked for; None while a perturbation or the nurse has the arms.
        disturbed: Something else than what was asked for reached the driver.
        exchange: The scrub nurse exchanges or reloads the right tool; the policies pause.
        applied: The perturbations that set in with this step.
        altered: What the safety filter noted about this step's command.
        heard: What people said before it, and what came of that.
        hand: The person's hand that led an arm.
        ahead: What is left of the controller's chunk.
        spent_s: Time on the clock by stage, since the step before.
    """

    time_s: float
    instruction: Instruction
    command: JointCommand
    observation: Observation
    outcome: Outcome
    asked: ToolAction | None
    disturbed: bool
    exchange: bool
    applied: tuple[Applied, ...]
    altered: tuple[Entry, ...]
    heard: tuple[Heard, ...] = ()
    hand: GuidedArm | None = None
    ahead: Chunk = ()
    spent_s: Mapping[str, float] = field(default_factory=dict)


@dataclass(kw_only=True)
class Episode:
    """The running state of one episode.

    Attributes:
        observation: What is seen now.
        inbox: Where people speak to it.
        effects: What disturbs it.
        tasks: What became of each task begun so far, by its index.
        exchange_s: Simulated time of tool exchanges so far.
        ledger: What the safety filter altered so far.
        clearance_m: The smallest between an instrument and what it keeps out of.
    """

    config: EpisodeConfig
    world: World
    planner: Planner[Observation]
    controller: Controller
    observation: Observation
    inbox: Inbox = field(default_factory=Inbox)
    effects: Effects = field(default_factory=Effects)
    tasks: dict[int, TaskResult] = field(default_factory=dict)
    exchange_s: float = 0.0
    ledger: list[Entry] = field(default_factory=list)
    clearance_m: float = math.inf

    def __post_init__(self) -> None:
        self.driver = Driver(rig_in(self.world), self.observation.joints)
        self.filter = SafetyFilter(self.world) if self.config.safety_filter else None
        self._begun = False
        self._chunk: deque[ToolAction] = deque()
        self._clock = StageClock()
        self._n_told = 0  # entries of the ledger that observers have been told of
        self._led_by: GuidedArm | None = None
        self._heeded: tuple[str, Source, float] | None = None  # the correction in force
        self._heard: list[Heard] = []  # of which observers have not been told

    def steps(self) -> Iterator[Step]:
        """The loop: plan, hear, exchange tools when needed, act; until done or out of time.

        Called again, or on a copy, it goes on from where the episode is.
        """
        if not self._begun:
            self._begin()
        while True:
            self._hear()
            while self._needs_exchange():
                yield from self._exchange()
            asked, action = self._next_action()
            step = self._step(
                self._drive(action), asked=asked, disturbed=action is not asked, hand=self._led_by
            )
            self._note(step)
            yield step
            if self._is_over(step):
                return
            if self._has_news(step) or self._plan_is_due():
                self._follow(self._plan())

    def _begin(self) -> None:
        self._override = PlannerOverridden(self.planner, duct=_duct_in(self.world))
        self._instruction = self._plan()
        self._begun = True

    def _plan(self) -> Instruction:
        self._planned_s = self._time_s
        with self._clock.stage("planner"):
            return self._override.plan(self.observation)

    def _hear(self) -> None:
        """Take in what people have said, and let go of what has lapsed of it."""
        for reading in self.inbox.take(self._time_s):
            self._heard.append(self._answer(reading))
        for perturbation in self.inbox.disturbances():
            self.effects.add(perturbation)
        self._follow(self._override.in_force(self._time_s))

    def _answer(self, reading: Reading) -> Heard:
        if reading.command is None:
            answer = Answer(instruction=None, reply=reading.reply)
        else:
            answer = self._override.instruct(reading.command, self.observation, reading.confidence)
        return Heard(
            time_s=self._time_s,
            reading=reading,
            instruction=answer.instruction,
            reply=answer.reply,
        )

    def _follow(self, instruction: Instruction) -> None:
        if instruction.text != self._instruction.text:
            self._drop_chunk()
        self._instruction = instruction

    def _has_news(self, step: Step) -> bool:
        """A task is done, of which a privileged planner hears; a person's keeps its time."""
        done = step.outcome.task_done and step.instruction.source == "planner"
        return done and self.planner.hears_of_success

    def _plan_is_due(self) -> bool:
        return self._time_s - self._planned_s >= PLANNING_PERIOD_S - 1e-9

    def _next_action(self) -> tuple[ToolAction | None, ToolAction]:
        """What is asked for, and what is done.

        Where the arms are to stay, or a perturbation leads one astray, the controller is not asked
        and begins anew later.
        """
        if self._instruction.hold:
            self.controller.reset()
            stay = hold(self.driver.joints[:, 6])
            return stay, self._led_by_hand(stay)
        if (led := self.effects.lead(self.world, self._instruction.task)) is not None:
            self._drop_chunk()
            self.controller.reset()
            self._led_by = None
            return None, led
        asked = self._chosen_action()
        return asked, self._led_by_hand(self.effects.on_action(asked, self.world))

    def _led_by_hand(self, action: ToolAction) -> ToolAction:
        """A person may lead one arm; the other one goes on."""
        self._led_by = hand = self.inbox.hand
        return action if hand is None else hand.lead(action, self.world)

    def _chosen_action(self) -> ToolAction:
        """Of the running chunk; when that has ended, the first of a new one."""
        if not self._chunk:
            with self._clock.stage("controller"):
                self._chunk.extend(self.controller.act(self.observation, self._instruction))
        if not self._chunk:
            raise ValueError("controller: a chunk must hold at least one action, got none")
        return self._chunk.popleft()

    def _drive(self, action: ToolAction) -> JointCommand:
        """Motions are meant in the frame of the endoscope, wherever that is by now."""
        self.driver.calibrate(rig_in(self.world))
        start, refused = self.driver.joints, self.driver.refused
        with self._clock.stage("driver"):
            asked = self.driver.drive(action)
        if self.driver.refused > refused:
            self.ledger.append(Entry(time_s=self._time_s, limits=("reach: an arm holds",)))
        return asked if self.filter is None else self._filtered(self.filter, start, asked)

    def _filtered(self, safety: SafetyFilter, start: Array, asked: JointCommand) -> JointCommand:
        """What the filter allows; the driver goes on from there."""
        with self._clock.stage("safety filter"):
            allowed = safety.allow(start, asked.joints, self._instruction, self._time_s)
        self.clearance_m = min(self.clearance_m, allowed.clearance_m)
        if allowed.entry is not None:
            self.ledger.append(allowed.entry)
            self.driver.follow(allowed.joints)
        return JointCommand(joints=allowed.joints)

    def _drop_chunk(self) -> None:
        self._chunk.clear()

    def _needs_exchange(self) -> bool:
        """The nurse acts only while the right arm is clear of the tubes."""
        task = self._instruction.task
        clip = task.kind == "clip" and not task_done(task, self.world)
        needed = nurse.is_needed(self.world, task.right_tool, clip=clip)
        return needed and not self._instruction.hold and right_arm_back(self.world)

    def _exchange(self) -> Iterator[Step]:
        start_s, joints = self._time_s, self.driver.joints
        self._drop_chunk()
        for command in nurse.exchange(self.world, self._instruction.task.right_tool, joints):
            self._hear()
            if self._instruction.hold:  # what is left of it follows later
                joints = self.world.target
                break
            yield self._step(command, exchange=True)
        self.driver.attach(rig_in(self.world), self.world.arms.limited(joints))
        if self.filter is not None:
            self.filter.restart()
        self.controller.reset()
        self.exchange_s += self._time_s - start_s

    def _step(
        self,
        command: JointCommand,
        *,
        asked: ToolAction | None = None,
        disturbed: bool = False,
        exchange: bool = False,
        hand: GuidedArm | None = None,
    ) -> Step:
        task, n_before = self._instruction.task, len(self.world.record.injuries)
        altered = tuple(self.ledger[self._n_told :])
        self._n_told = len(self.ledger)
        heard, self._heard = tuple(self._heard), []
        self.effects.before_step(self.world, task)
        with self._clock.stage("world"):
            self.observation = self.world.step(command, intended=structure_of(task, self.world))
        return Step(
            time_s=self._time_s,
            instruction=self._instruction,
            command=command,
            observation=self.observation,
            outcome=Outcome(
                events=self.world.record.injuries[n_before:],
                task_done=task_done(task, self.world),
            ),
            asked=asked,
            disturbed=disturbed,
            exchange=exchange,
            applied=self.effects.news(),
            altered=altered,
            heard=heard,
            hand=hand,
            ahead=tuple(self._chunk),
            spent_s=self._clock.read(),
        )

    def _note(self, step: Step) -> None:
        """Count the step to its task; done once is done, unless it is taken up again.

        What was left undone or never said, and what the planner is at, may come to be done under
        another word.
        """
        self._credit(
            step.instruction.task,
            success=step.outcome.task_done,
            time_s=self.world.config.control_step_s,
            corrections=int(self._begins_correction(step.instruction)),
        )
        planned = self._override.planned.task
        done = {TASKS[k - 1] for k, task in self.tasks.items() if task.success}
        due = {*TASKS[: planned.index], *(TASKS[k - 1] for k in self.tasks)}
        for task in (due - done) | {planned}:
            if task != step.instruction.task and task_done(task, self.world):
                self._credit(task, success=True)

    def _credit(
        self, task: Task, *, success: bool, time_s: float = 0.0, corrections: int = 0
    ) -> None:
        before = self.tasks.get(task.index)
        self.tasks[task.index] = TaskResult(
            index=task.index,
            instruction=task.text,
            success=success,
            time_s=(before.time_s if before else 0.0) + time_s,
            corrections=(before.corrections if before else 0) + corrections,
        )

    def _begins_correction(self, instruction: Instruction) -> bool:
        """Whether a correction is heard that was not heard the step before."""
        before, self._heeded = self._heeded, _correction_in(instruction)
        return self._heeded not in (None, before)

    def _is_over(self, step: Step) -> bool:
        """Done, or out of time, or in the last task, which is done, with nothing left to cut.

        The last task alone is not the end: it is also how one backs off from the last cut.
        """
        task = step.instruction.task
        if self.tasks[task.index].time_s > self.config.task_cap_s:
            return True
        if task != TASKS[-1] or not step.outcome.task_done:
            return False
        return self.is_done or all(tube_severed(self.world, tube) for tube in TUBES)

    @property
    def is_done(self) -> bool:
        """Whether all 17 tasks are, in whatever order."""
        return len(self.tasks) == len(TASKS) and all(t.success for t in self.tasks.values())

    @property
    def _time_s(self) -> float:
        return self.observation.time_s


def result_of(episode: Episode, start_s: float) -> EpisodeResult:
    """Pull at the clips and sum the episode up, which began at `start_s` of `perf_counter`."""
    config, world = episode.config, episode.world
    tasks = tuple(episode.tasks[k] for k in sorted(episode.tasks))
    procedure_s = world.record.time_s - episode.exchange_s
    pull_all_clips(world)
    injuries = world.record.injuries
    return EpisodeResult(
        scenario=config.scenario,
        seed=config.seed,
        planner=config.planner,
        controller=config.controller,
        success=episode.is_done and stumps_hold(world) and not injuries,
        tasks=tasks,
        procedure_time_s=procedure_s,
        exchange_time_s=episode.exchange_s,
        wall_s=time.perf_counter() - start_s,
        corrections=sum(task.corrections for task in tasks),
        dropped_clips=world.record.dropped_clips,
        injuries=tuple(
            InjuryResult(event=i.event, time_s=i.time_s, value=i.value, limit=i.limit)
            for i in injuries
        ),
        safety=_safety(episode),
        anatomy_hash=world.anatomy.hash,
    )


def _safety(episode: Episode) -> SafetyResult:
    ledger = tuple(episode.ledger)
    return SafetyResult(
        filter=episode.filter is not None,
        interventions=len(ledger),
        min_clearance_m=episode.clearance_m if math.isfinite(episode.clearance_m) else None,
        ledger=ledger,
    )


def _correction_in(instruction: Instruction) -> tuple[str, Source, float] | None:
    """What tells one correction from the next: a person's are told apart by when they were given.

    A planner repeats its own as long as it means it.
    """
    if instruction.correction is None:
        return None
    given_s = instruction.time_s if instruction.source == "human" else 0.0
    return instruction.text, instruction.source, given_s


def _duct_in(world: World) -> Tube:
    return "left" if world.anatomy.structure("left") == "duct" else "right"


def rig_in(world: World) -> Rig:
    """As calibrated in this world now."""
    return rig_of(world.arms.T_world_rcm, world.T_world_endoscope, world.arms.mounted)
