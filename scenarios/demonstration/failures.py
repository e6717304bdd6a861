"""Cause failures on purpose, find unplanned ones, and track which failures persist."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pkgutil import resolve_name
from typing import TYPE_CHECKING

import numpy as np

from controller.expert.skills import among_tissue
from controller.expert.targets import clip_pose
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.outcomes import has_tube, structure_of
from planner.procedure.task import Task
from scenarios.catalogue import SCENARIOS
from scenarios.loop.step import Step
from scenarios.perturbation.perturbation import AtTask, Perturbation
from tissue_sim.outcome.predicates import gallbladder_grasped, gallbladder_held, grasper_hooked
from tissue_sim.thresholds import CLIPS_LEFT_MAX
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

if TYPE_CHECKING:
    from tissue_sim.patient.anatomy import Anatomy
    from tissue_sim.world import World

MAX_FAILURES = 3  # in an episode, each in a different task; fewer dropped clips: more injure
WEAKEST = 0.5  # smallest share of the scenario's magnitude
SLIP, HOOK, DROP = "grasp-slip", "grasp-hooked", "clip-dropped"
PAST_M = 0.001  # of the tube, half of the weakest overshoot


def failures(scenario: str, anatomy: Anatomy, rng: np.random.Generator) -> tuple[Perturbation, ...]:
    """Draw the scenario's perturbation in several of the patient's tasks, with random magnitudes.

    Only a patient with a second artery has the tasks of the third tube.
    """
    return tuple(
        replace(p, at=AtTask(index=int(task)), magnitude=_drawn_magnitude(p, rng))
        for p in SCENARIOS[scenario].perturbations
        for task in _drawn_tasks(p, anatomy, rng)
    )


def _drawn_tasks(p: Perturbation, anatomy: Anatomy, rng: np.random.Generator) -> list[int]:
    tasks = [k for k in resolve_name(p.effect).tasks if has_tube(CHOLECYSTECTOMY.task(k), anatomy)]
    most = CLIPS_LEFT_MAX if p.name == DROP else MAX_FAILURES
    return sorted(rng.choice(tasks, size=min(most, len(tasks)), replace=False).tolist())


def _drawn_magnitude(p: Perturbation, rng: np.random.Generator) -> float:
    """Draw the magnitude; a slip is always full, because with some friction none occurs."""
    full = p.whole or p.name == SLIP
    return p.magnitude if full else p.magnitude * float(rng.uniform(WEAKEST, 1.0))


class FailureTracker:
    """Tracks which failures persist, step by step."""

    def __init__(self) -> None:
        self._names: set[str] = set()
        self._grasped = False  # and not lost since

    def after(self, step: Step, world: World) -> bool:
        """Return whether any failure persists after the step."""
        led, task = step.asked is None, step.instruction.task
        self._names |= {applied.name for applied in step.applied} & UNDONE.keys()
        if step.outcome.task_done:  # the other failures no longer matter
            self._names &= {SLIP}
        if not led:
            self._names |= self._unplanned(world)
            self._names -= {name for name in self._names if UNDONE[name](world, task)}
        return any(name != SLIP or not gallbladder_held(world) for name in self._names)

    def _unplanned(self, world: World) -> set[str]:
        """Return unplanned failures: the grasp was lost, or the grasper is hooked."""
        self._grasped |= gallbladder_grasped(world)
        lost = self._grasped and not gallbladder_held(world)
        self._grasped &= not lost
        return {name for name, so in ((SLIP, lost), (HOOK, grasper_hooked(world))) if so}


def _arm_is_out(arm: int) -> Callable[[World, Task], bool]:
    return lambda world, _: not among_tissue(arm, world)


def _no_longer_past(world: World, task: Task) -> bool:
    """Return whether the applier is out of the tissue, or no deeper than its goal."""
    if not among_tissue(RIGHT_ARM, world):
        return True
    if task.tube is None or task.clip is None:
        return False
    goal = clip_pose(world, structure_of(task, world), task.clip)
    T = world.arms.T_world_tool()[RIGHT_ARM]
    return bool((T[:3, 3] - goal[:3, 3]) @ T[:3, 2] < PAST_M)


def _grasp_needs_no_undoing(world: World, task: Task) -> bool:
    """Return whether the grasper holds, is out of the tissue, or need not grasp after a cut."""
    holds = world.conditions.grip == 1.0 and gallbladder_held(world)
    return holds or bool(world.record.cuts) or not among_tissue(LEFT_ARM, world)


UNDONE: dict[str, Callable[[World, Task], bool]] = {
    "grasp-missed-above": _arm_is_out(LEFT_ARM),
    "grasp-missed-below": _arm_is_out(LEFT_ARM),
    "wrong-tube": _arm_is_out(RIGHT_ARM),
    "both-tubes": _arm_is_out(RIGHT_ARM),
    "overshoot": _no_longer_past,
    SLIP: _grasp_needs_no_undoing,
    HOOK: _grasp_needs_no_undoing,
    DROP: lambda world, _: world.record.clip_loaded,
}
"""By perturbation: whether the failure that it caused in a task is undone."""
