"""Fork a demonstration: from one state, the expert carries out several commands, each to its end.

In a procedure each state has one command, so the state explains the motion, and a policy need not
learn the words. Forks of one state differ in nothing but the command.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from controller.expert.controller import ControllerExpert
from planner.correction import CORRECTIONS, Correction
from planner.instruction import Instruction
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY, GRAB
from planner.procedure.task import Task
from planner.scene.next_task import NotNowError, next_task
from scenarios.demonstration.demonstration_recorder import DemonstrationRecorder, is_frame
from scenarios.demonstration.interjections import PlannerFixed, harmless_m, is_harmless
from scenarios.episode import Episode
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.outcome import nurse
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import RIGHT_ARM

if TYPE_CHECKING:
    from numpy.random import Generator

    from scenarios.loop.step import Step
    from tissue_sim.world import World

# Assumed, all of them.
BETWEEN_S = (1.0, 3.5)  # from one state that is forked to the next
CORRECTIONS_A_STATE, TASKS_A_STATE = 3, 1
ANGLE_RAD = (0.1, 0.8)  # of a correction of the jaws
NAMED = 0.8  # share of corrections with a distance or an angle
UNNAMED_S, LONGEST_S = (0.6, 1.5), 4.0  # of a correction without a distance, and with one
REACHED_M, REACHED_RAD = 1e-4, 0.02
RESTS_S = (0.0, 1.2)  # at the distance
GOES_ON_S, TASK_S, AFTER_S = (0.8, 2.5), (1.5, 4.0), 0.2
RARE = {"left": 1.0, "right": 1.0, "both": 0.7}  # weight of a correction by its arm


@dataclass(frozen=True, kw_only=True)
class Leg:
    """A part of a fork: one instruction, and the longest time for it.

    Attributes:
        rests_s: Time at the end of a named distance.
    """

    said: Instruction
    most_s: float
    rests_s: float = 0.0


class Forks:
    """Observes a demonstration, and forks it at random times. The demonstration is not changed.

    Forks that injure the patient are dropped.
    """

    def __init__(self, episode: Episode, rng: Generator) -> None:
        self._episode, self._rng = episode, rng
        self._n = 0
        self._due_s = rng.uniform(*BETWEEN_S)
        self._forks: list[tuple[int, DemonstrationRecorder]] = []

    def on_reset(self, world: World) -> None:
        """Do nothing: the first state is forked later."""

    def on_step(self, step: Step) -> None:
        """Count a frame, and fork the state after the step if it is time."""
        self._n += is_frame(step)
        free = is_frame(step) and step.asked is not None and not step.instruction.call
        if free and step.time_s >= self._due_s:
            self._due_s = step.time_s + self._rng.uniform(*BETWEEN_S)
            self._fork(step)

    def on_end(self, result: object) -> None:
        """Do nothing: `joined` returns the frames."""

    def joined(self, columns: Mapping[str, np.ndarray], seed: int, kind: str) -> dict:
        """Return the demonstration's columns, with those of its forks after them."""
        parts = [dict(columns)]
        for row, recorder in self._forks:
            part = recorder.columns(seed, kind)
            part["forked_from"] = np.full(len(part["seed"]), row)
            part["segment"] = part["segment"] + parts[-1]["segment"][-1] + 1
            parts.append(part)
        whole = {name: np.concatenate([part[name] for part in parts]) for name in columns}
        numbers = np.arange(len(whole["seed"]))
        whole["frame_index"] = numbers
        whole["timestamp"] = (numbers * CONTROL_PERIOD_S).astype(np.float32)
        return whole

    def _fork(self, step: Step) -> None:
        episode = self._episode
        world, state = episode.world, episode.world.state()
        for legs in self._commands(step.instruction.task, step.exact):
            recorder = DemonstrationRecorder(lambda: True)
            recorder.on_reset(world)
            n_injuries = len(world.record.injuries)
            _carry_out(legs, episode, recorder)
            if recorder.has_frames and len(world.record.injuries) == n_injuries:
                self._forks.append((self._n, recorder))
            world.restore(state)

    def _commands(self, task: Task, exact: Observation) -> Iterator[Sequence[Leg]]:
        """Yield the legs of each fork of the present state."""
        world, rng = self._episode.world, self._rng
        able = [c for c in CORRECTIONS if is_harmless(c, world)]
        weight = np.array([RARE[c.arm] for c in able])
        n = min(CORRECTIONS_A_STATE, len(able))
        for k in rng.choice(len(able), n, replace=False, p=weight / weight.sum()):
            corrected = self._corrected(able[k], task)
            goes_on = Leg(said=Instruction(task=task), most_s=rng.uniform(*GOES_ON_S))
            yield corrected, goes_on
        others = _other_tasks(task, exact, world)
        n = min(TASKS_A_STATE, len(others))
        for k in rng.choice(len(others), n, replace=False) if n else ():
            yield (Leg(said=Instruction(task=others[k]), most_s=rng.uniform(*TASK_S)),)

    def _corrected(self, correction: Correction, task: Task) -> Leg:
        rng, said = self._rng, Instruction(task=task, correction=correction)
        if rng.random() > NAMED:
            return Leg(said=said, most_s=rng.uniform(*UNNAMED_S))
        if correction.direction is None:
            said = replace(said, left_rad=rng.uniform(*ANGLE_RAD))
        else:
            said = replace(said, left_m=harmless_m(correction, self._episode.world, rng))
        return Leg(said=said, most_s=LONGEST_S, rests_s=rng.uniform(*RESTS_S))


def _carry_out(legs: Sequence[Leg], episode: Episode, recorder: DemonstrationRecorder) -> None:
    world = episode.world
    sense, observation = deepcopy(episode.sense, {id(world): world}), episode.observation
    for leg in legs:
        fork = Episode(
            config=episode.config,
            world=world,
            planner=PlannerFixed(instruction=replace(leg.said, time_s=world.record.time_s)),
            controller=ControllerExpert(world),
            sense=sense,
            observation=observation,
        )
        fork.guarded_driver.driver.follow(world.target)
        lasted_s, ends_s = 0.0, leg.most_s
        for step in fork.steps():
            if step.exchange:  # it is no motion of this state
                return
            recorder.on_step(step)
            lasted_s += CONTROL_PERIOD_S * is_frame(step)
            if leg.said.correction is None and step.outcome.task_done:
                ends_s = min(ends_s, lasted_s + AFTER_S)
            elif _is_there(fork.instruction):
                ends_s = min(ends_s, lasted_s + leg.rests_s)
            if lasted_s >= ends_s:
                break
        observation = fork.observation


def _is_there(said: Instruction) -> bool:
    """Return whether a correction has gone its named distance or angle."""
    by_m = said.left_m is not None and said.left_m <= REACHED_M
    return by_m or (said.left_rad is not None and said.left_rad <= REACHED_RAD)


def _other_tasks(task: Task, exact: Observation, world: World) -> list[Task]:
    """Return the tasks, other than the present one, that may be given in this state."""
    others = [] if world.record.cuts else [GRAB]
    if task.is_deed and (back := CHOLECYSTECTOMY.retraction_after(task)) is not None:
        others.append(back)
    for tube in exact.tubes:
        for deed in ("clip", "cut"):
            try:
                others.append(next_task(deed, tube, exact))
            except NotNowError:
                continue
    return [other for other in others if other != task and _is_possible(other, exact, world)]


def _is_possible(task: Task, exact: Observation, world: World) -> bool:
    """Return whether the mounted tool serves a task, or the nurse has room to exchange it."""
    mounted = world.arms.mounted[RIGHT_ARM]
    if not task.is_deed or nurse.has_room(exact):
        return True
    return mounted.deed == ("cut" if task.severs else "clip") and (
        exact.clip_loaded or not task.places_clip
    )
