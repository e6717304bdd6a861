"""What a correction gains: from one moment the episode goes on with it and without, all else equal.

The moment is when an arm that was led astray is given back; the correction is the one that points
from the tip to where the task is rightly done, as a person who sees it would say.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from controller.expert.targets import clip_pose, cut_pose, grasp_pose
from planner.command import COMMANDS
from planner.criteria import structure_of, task_done
from planner.task import Task
from scenarios.demonstration.labels import correction_of
from scenarios.episode import Episode
from scenarios.files.errors import describe_with_place
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.step import Step
from scenarios.recording.snapshot import Snapshot
from scenarios.run_episode import begin
from tissue_sim.frames import Array
from tissue_sim.periods import CONTROL_PERIOD_S
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.world import World

SAID_S = 1.0  # then back to the planner: over its 5 s a correction goes too far
LOOK_S = 2.0  # when the tip's distance to its goal is compared
WITHIN_S = 20.0  # in which the task is done or is not


@dataclass(frozen=True, kw_only=True)
class Course:
    """How the episode went on.

    Attributes:
        off_m: of the working tip from its goal after `LOOK_S`.
        done_s: from the moment until the task is done; None where it is not within `WITHIN_S`.
        injuries: in that time.
    """

    off_m: float
    done_s: float | None
    injuries: int


@dataclass(frozen=True, kw_only=True)
class CorrectionTrial:
    """Of one patient.

    Attributes:
        correction: what was said; "" where nothing went astray or nothing was to be said.
        without, told: the two courses; None without a correction.
        error: what ended the trial, if anything did.
    """

    seed: int
    correction: str = ""
    without: Course | None = None
    told: Course | None = None
    error: str = ""


@dataclass(frozen=True, kw_only=True)
class ForkComparison:
    """With and without, by an episode's settings; the seed is each trial's."""

    config: EpisodeConfig

    def __call__(self, seed: int) -> CorrectionTrial:
        """On a seed's patient."""
        episode = begin(replace(self.config, seed=seed))
        step = _given_back(episode.steps())
        if step is None:
            return CorrectionTrial(seed=seed)
        task, moment = step.instruction.task, Snapshot(episode)
        correction = correction_of(*wanted_motion(task, episode.world))
        if not correction:
            return CorrectionTrial(seed=seed)
        without = _course(moment.again(), task, "")
        told = _course(moment.again(), task, correction)
        return CorrectionTrial(seed=seed, correction=correction, without=without, told=told)


def lost_trial(seed: int, error: Exception) -> CorrectionTrial:
    """The trial that an exception, or its process's death, ended."""
    return CorrectionTrial(seed=seed, error=describe_with_place(error))


def _given_back(steps: Iterator[Step]) -> Step | None:
    """The first step in which the controller has the arms again; None if they were never taken."""
    astray = False
    for step in steps:
        if astray and step.asked is not None:
            return step
        astray = astray or (step.asked is None and not step.exchange)
    return None


def _course(episode: Episode, task: Task, correction: str) -> Course:
    """From the episode's moment on, a correction being said first, if there is one."""
    if correction:
        episode.inbox.press(COMMANDS[correction])
    world, steps = episode.world, episode.steps()
    start_s, n_injuries = world.record.time_s, len(world.record.injuries)
    off_m, done_s = np.nan, None
    for n, step in enumerate(islice(steps, round(WITHIN_S / CONTROL_PERIOD_S)), start=1):
        if correction and n == round(SAID_S / CONTROL_PERIOD_S):
            episode.inbox.press(COMMANDS["resume"])
        if n == round(LOOK_S / CONTROL_PERIOD_S):
            off_m = float(np.linalg.norm(wanted_motion(task, world)[0]))
        if done_s is None and task_done(task, world):
            done_s = step.time_s - start_s
        if done_s is not None and n * CONTROL_PERIOD_S >= LOOK_S:
            break
    return Course(off_m=off_m, done_s=done_s, injuries=len(world.record.injuries) - n_injuries)


def wanted_motion(task: Task, world: World) -> tuple[Array, Array]:
    """What would put the tip that works on the task right, as `correction_of` takes it.

    Returns:
        (2, 3) of both tips, m in the endoscope frame, and (2,) of the jaws, none.
    """
    arm, goal = _goal(task, world)
    way = goal[:3, 3] - world.arms.T_world_tool()[arm][:3, 3]
    moved_m = np.zeros((2, 3))
    moved_m[arm] = way @ world.T_world_endoscope[:3, :3]
    return moved_m, np.zeros(2)


def _goal(task: Task, world: World) -> tuple[int, Array]:
    """Whose tip the task is about, and its `T_world_tool` where it is rightly done."""
    if task.kind == "grab":
        return LEFT_ARM, grasp_pose(world)
    tube = structure_of(task, world)
    pose = cut_pose(world, tube) if task.kind == "cut" else clip_pose(world, tube, task.clip or 1)
    return RIGHT_ARM, pose
