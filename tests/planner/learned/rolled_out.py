"""A made-up rollout: the observation tells which task is due."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planner.learned.features import N_CORRECTIONS, N_TASKS
from planner.learned.rollout import NOT_SAID, Rollout
from tissue_sim.constants import CONTROL_HZ
from tissue_sim.sensing.observation import VECTOR_SIZE, fields
from tissue_sim.tools.instruments import right_tools

TASK_STEPS = 2 * CONTROL_HZ


def rollout(seed: int = 0, tasks: int = N_TASKS) -> Rollout:
    """Return a rollout in which each task takes two seconds and the body is at rest.

    At the start of every third task, a correction is wanted.
    """
    rng = np.random.default_rng(seed)
    task = np.repeat(np.arange(tasks), TASK_STEPS)
    n = len(task)
    states = rng.normal(scale=0.1, size=(n, VECTOR_SIZE)).astype(np.float32)
    wanted = (task % 3 == 0) & (np.arange(n) % TASK_STEPS < CONTROL_HZ)
    seen = fields(states)
    seen["tubes_m"][:, :, 0] = seen["tubes_m"][0, :, 0]
    seen["third_tube"][:] = 0.0
    seen["sac_m"][:, 0, 0] = 0.01 * task
    for name in ("n_clips", "clip_loaded", "hidden"):
        seen[name][:] = 1.0
    seen["severed"][:], seen["rest_length_m"][:], seen["rest_length_std_m"][:] = 0.0, 0.03, 0.0
    seen["right_tool"][:] = np.eye(len(right_tools()))[0]
    seen["clips_m"] += 1.0  # on neither tube
    seen["forces_n"][:, 0, 0] = wanted
    return Rollout(
        states=states,
        said=task,
        corrected=np.where(wanted, task % N_CORRECTIONS, NOT_SAID),
        task=task,
        correction=np.where(wanted, task % N_CORRECTIONS, NOT_SAID),
        success=True,
    )


def with_tasks(task: list[int], *, success: bool = True) -> Rollout:
    """Return a rollout in which each of these tasks lasts four seconds."""
    column = np.repeat(task, 4 * CONTROL_HZ)
    made = replace(rollout(tasks=len(column) // TASK_STEPS), success=success)
    return replace(made, task=column, said=column)
