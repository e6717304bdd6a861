"""One episode: the loop in which planner, controller and world meet. Read this file first.

    world --Observation--> planner (1 Hz) --Instruction--> controller (a chunk at a time)
      --ToolAction--> driver (30 Hz) --JointCommand--> world --Outcome--> observers
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pkgutil import resolve_name


from controller.action import Chunk
from controller.base import Controller
from controller.driver import Driver, rig_of
from planner.base import Planner
from planner.criteria import structure_of, task_done
from planner.instruction import TASKS, Instruction, Task
from scenarios.catalogue import CONTROLLERS, PLANNERS
from scenarios.episode_config import EpisodeConfig
from scenarios.observer import Observer
from scenarios.results import EpisodeResult, InjuryResult, SafetyResult, TaskResult
from tissue_sim import nurse
from tissue_sim.anatomy import anatomy_from_seed
from tissue_sim.arms import JointCommand
from tissue_sim.injury import Injury
from tissue_sim.observation import Observation
from tissue_sim.outcome import right_arm_back, stumps_hold
from tissue_sim.retention import pull_all_clips
from tissue_sim.world import World

PLAN_PERIOD_S = 1.0
TASK_MOST_S = 90.0  # SRT-H's cap


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a step did to the patient, and whether the running task's criterion is met."""

    events: tuple[Injury, ...]
    task_done: bool


@dataclass(frozen=True, kw_only=True)
class Step:
    """One control step, as observers see it."""

    time_s: float
    instruction: Instruction
    command: JointCommand
    observation: Observation
    outcome: Outcome
    exchange: bool


@dataclass(kw_only=True)
class Episode:
    """The running state of one episode."""

    config: EpisodeConfig
    world: World
    planner: Planner[Observation]
    controller: Controller
    driver: Driver
    observation: Observation
    observers: Sequence[Observer]
    tasks: dict[int, TaskResult] = field(default_factory=dict)
    exchange_s: float = 0.0

    def run(self) -> None:
        """The loop: plan, exchange tools when needed, act; until done or out of time."""
        instruction = self.planner.plan(self.observation)
        planned_s = self._time_s
        chunk: Iterator = iter(())
        while True:
            if self._needs_exchange(instruction):
                chunk = iter(())
                self._exchange(instruction)
            if (action := next(chunk, None)) is None:
                chunk = iter(self.controller.act(self.observation, instruction))
                action = next(chunk)
            done = self._step(self.driver.drive(action), instruction).outcome.task_done
            self._note(instruction.task, done)
            if self.tasks[instruction.task.index].time_s > TASK_MOST_S:
                return
            if done and instruction.task == TASKS[-1]:
                return
            if done or self._time_s - planned_s >= PLAN_PERIOD_S - 1e-9:
                planned_s, before = self._time_s, instruction
                instruction = self.planner.plan(self.observation)
                if instruction.text != before.text:
                    chunk = iter(())

    @property
    def _time_s(self) -> float:
        return self.observation.time_s

    def _needs_exchange(self, instruction: Instruction) -> bool:
        """The nurse acts only while the right arm is clear of the tubes."""
        task = instruction.task
        clip = task.kind == "clip" and not task_done(task, self.world)
        needed = nurse.is_needed(self.world, task.right_tool, clip=clip)
        return needed and right_arm_back(self.world)

    def _exchange(self, instruction: Instruction) -> None:
        start_s = self._time_s
        joints = self.driver.joints
        for command in nurse.exchange(self.world, instruction.task.right_tool, joints):
            self._step(command, instruction, exchange=True)
        self.driver.attach(_rig(self.world), joints)
        self.controller.reset()
        self.exchange_s += self._time_s - start_s

    def _step(
        self, command: JointCommand, instruction: Instruction, *, exchange: bool = False
    ) -> Step:
        before = len(self.world.record.injuries)
        intended = structure_of(instruction.task, self.world)
        self.observation = self.world.step(command, intended=intended)
        step = Step(
            time_s=self._time_s,
            instruction=instruction,
            command=command,
            observation=self.observation,
            outcome=Outcome(
                events=self.world.record.injuries[before:],
                task_done=task_done(instruction.task, self.world),
            ),
            exchange=exchange,
        )
        for observer in self.observers:
            observer.on_step(step)
        return step

    def _note(self, task: Task, done: bool) -> None:
        """Count a step's time to its task; done once is done, unless it is taken up again."""
        before = self.tasks.get(task.index)
        self.tasks[task.index] = TaskResult(
            index=task.index,
            instruction=task.text,
            success=done,
            time_s=(before.time_s if before else 0.0) + self.world.config.control_step_s,
            corrections=0,
        )


def run_episode(config: EpisodeConfig, observers: Sequence[Observer] = ()) -> EpisodeResult:
    """Run one episode to its end and judge it.

    An exception ends the episode and is the caller's to record: it is no failed episode.
    """
    start_s = time.perf_counter()
    world = World(render=any(getattr(o, "needs_images", False) for o in observers))
    observation = world.reset(anatomy_from_seed(config.seed))
    episode = Episode(
        config=config,
        world=world,
        planner=resolve_name(PLANNERS[config.planner])(world),
        controller=resolve_name(CONTROLLERS[config.controller])(world),
        driver=Driver(_rig(world), observation.joints),
        observation=observation,
        observers=observers,
    )
    for observer in observers:
        observer.on_reset(world)
    episode.run()
    procedure_s = world.record.time_s - episode.exchange_s
    tasks = tuple(episode.tasks[k] for k in sorted(episode.tasks))
    done = len(tasks) == len(TASKS) and all(t.success for t in tasks)
    pull_all_clips(world)
    passed = done and stumps_hold(world) and not world.record.injuries
    result = EpisodeResult(
        scenario=config.scenario,
        seed=config.seed,
        planner=config.planner,
        controller=config.controller,
        success=passed,
        tasks=tasks,
        procedure_time_s=procedure_s,
        exchange_time_s=episode.exchange_s,
        wall_s=time.perf_counter() - start_s,
        injuries=tuple(
            InjuryResult(event=i.event, time_s=i.time_s, value=i.value, limit=i.limit)
            for i in world.record.injuries
        ),
        safety=SafetyResult(interventions=episode.driver.refused),
        anatomy_hash=world.anatomy.hash,
    )
    for observer in observers:
        observer.on_end(result)
    return result


def _rig(world: World):
    return rig_of(world.arms.T_world_rcm, world.T_world_endoscope, world.arms.mounted)
