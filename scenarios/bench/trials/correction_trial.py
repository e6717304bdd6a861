"""Measure the gain of a correction: an episode continues from one snapshot with and without it.

The snapshot is taken when the controller gets back an arm that was led astray. The correction
points from the tip to the task's goal, as an observing person would say.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from rich.table import Table

from controller.expert.targets import clip_pose, cut_pose, grasp_pose
from planner.command import COMMANDS
from planner.procedure.outcomes import structure_of, task_done
from planner.procedure.task import Task
from scenarios.bench.trials.run_trials import Trial
from scenarios.demonstration.labels import correction_of
from scenarios.episode import Episode
from scenarios.evaluation.paired import mcnemar_exact, mean_interval
from scenarios.evaluation.words import interval
from scenarios.files.outside_text import table_of
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.step import Step
from scenarios.recording.snapshot import Snapshot
from scenarios.run_episode import begin
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.world import World

SAID_S = 1.0  # then back to the planner: in its full 5 s a correction moves too far
LOOK_S = 2.0  # time at which the tip's distance to its goal is compared
WITHIN_S = 20.0  # time limit of the task


@dataclass(frozen=True, kw_only=True)
class Course:
    """The course of the continued episode.

    Attributes:
        off_m: Distance of the working tip from its goal after `LOOK_S`.
        done_s: Time until the task is done; None if it is not done within `WITHIN_S`.
        injuries: Number of injuries in that time.
    """

    off_m: float
    done_s: float | None
    injuries: int


@dataclass(frozen=True, kw_only=True)
class CorrectionTrial(Trial):
    """Result for one patient.

    Attributes:
        correction: Text of the correction; "" if no arm was led astray or no correction was needed.
        without, corrected: The two courses; None without a correction.
    """

    correction: str = ""
    without: Course | None = None
    corrected: Course | None = None


def compare_forks(seed: int, config: EpisodeConfig) -> CorrectionTrial:
    """Compare with and without, on a seed's patient, under an episode's configuration."""
    episode = begin(replace(config, seed=seed))
    step = _given_back(episode.steps())
    if step is None:
        return CorrectionTrial(seed=seed)
    task, snapshot = step.instruction.task, Snapshot(episode)
    correction = correction_of(*wanted_motion(task, episode.world))
    if not correction:
        return CorrectionTrial(seed=seed)
    without = _course(snapshot.again(), task, "")
    corrected = _course(snapshot.again(), task, correction)
    return CorrectionTrial(seed=seed, correction=correction, without=without, corrected=corrected)


def _given_back(steps: Iterator[Step]) -> Step | None:
    """Return the first step in which the controller regains the arms; None if never taken."""
    astray = False
    for step in steps:
        if astray and step.asked is not None:
            return step
        astray = astray or (step.asked is None and not step.exchange)
    return None


def _course(episode: Episode, task: Task, correction: str) -> Course:
    """Continue the episode; submit the correction first if there is one."""
    if correction:
        episode.inbox.press(COMMANDS[correction])
        episode.inbox.say("yes")  # confirms that the held tissue may be released
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
    """Return the motion from the working tip to the task's goal, as `correction_of` takes it.

    Returns:
        (2, 3) motion of both tips, m, endoscope frame; and (2,) zeros for the jaws.
    """
    arm, goal = _goal(task, world)
    offset = goal[:3, 3] - world.arms.T_world_tool()[arm][:3, 3]
    moved_m = np.zeros((2, 3))
    moved_m[arm] = offset @ world.T_world_endoscope[:3, :3]
    return moved_m, np.zeros(2)


def _goal(task: Task, world: World) -> tuple[int, Array]:
    """Return the working arm of the task, and `T_world_tool` at the task's goal."""
    if task.grasps:
        return LEFT_ARM, grasp_pose(world)
    tube = structure_of(task, world)
    pose = cut_pose(world, tube) if task.severs else clip_pose(world, tube, task.clip or 1)
    return RIGHT_ARM, pose


def corrections_table(trials: Sequence[CorrectionTrial]) -> Table:
    """Return a table: without, with, and the paired gain with its 95 % interval."""
    title = f"corrections, seeds {trials[0].seed} to {trials[-1].seed}"
    table = table_of(title, ("",), ("without", "with", "gain (95 % interval, paired)"), ())
    without = [trial.without for trial in trials if trial.without]
    corrected = [trial.corrected for trial in trials if trial.corrected]
    table.add_row("moments", str(len(without)), str(len(corrected)), "")
    if not corrected:
        return table
    off_mm, took_s, done, unhurt = zip(*map(_columns, (without, corrected)), strict=True)
    _add_mean(table, f"mm to the goal after {LOOK_S:g} s", *off_mm)
    _add_mean(table, f"s to the task, {WITHIN_S:g} at most", *took_s)
    _add_count(table, f"task done in {WITHIN_S:g} s", *done)
    _add_count(table, "nothing injured", *unhurt)
    return table


def _columns(courses: Sequence[Course]) -> tuple[list, ...]:
    """Return distances to the goal (mm), times to the task (s), which were done, and unhurt."""
    return (
        [1e3 * course.off_m for course in courses],
        [WITHIN_S if course.done_s is None else course.done_s for course in courses],
        [course.done_s is not None for course in courses],
        [not course.injuries for course in courses],
    )


def _add_mean(table: Table, what: str, before: Sequence[float], after: Sequence[float]) -> None:
    saved = np.subtract(before, after)
    table.add_row(
        what,
        f"{np.mean(before):.1f}",
        f"{np.mean(after):.1f}",
        f"{saved.mean():.1f} ({interval(mean_interval(saved.tolist()), 1)})",
    )


def _add_count(table: Table, what: str, before: Sequence[bool], after: Sequence[bool]) -> None:
    better = sum(b < a for b, a in zip(before, after, strict=True))
    worse = sum(b > a for b, a in zip(before, after, strict=True))
    change = f"{better} better, {worse} worse (p = {mcnemar_exact(better, worse):.3f})"
    table.add_row(what, str(sum(before)), str(sum(after)), change)
