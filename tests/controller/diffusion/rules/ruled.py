"""Chunks for rules, what a rule makes of one arm's motions, and that it changes nothing else."""

import numpy as np
from numpy.typing import NDArray

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import TURN
from controller.diffusion.rules.chunk_rules import Rule
from controller.diffusion.rules.holding import UNTURNED
from controller.diffusion.scene.scene import Scene
from planner.procedure.task import Task
from tissue_sim.frames import Array

STEPS = 16  # of a chunk
CLOSED = np.zeros((1, 2))  # commanded jaw angles before a chunk


def still() -> Array:
    """Return a chunk (16, 2, 10) in which both arms stay where they are, jaws at 0."""
    arms = np.zeros((STEPS, 2, ACTION_SIZE // 2))
    arms[..., TURN] = UNTURNED
    return arms


def apply(
    rule: Rule,
    asked: Array,
    vector: NDArray[np.float32],
    task: Task,
    commanded: Array = CLOSED,
) -> Array:
    """Return a chunk (n, 20) after a rule, by what is observed at its start."""
    return rule(asked, Scene(vector), task, commanded)


def arm_after(rule: Rule, arm: int, asked: Array, vector: NDArray[np.float32], task: Task) -> Array:
    """Return an arm's rows (n, 10) of a chunk (n, 20) after a rule.

    The chunk itself and the other arm must not change.
    """
    kept = asked.copy()
    arms = apply(rule, asked, vector, task).reshape(len(asked), 2, -1)
    assert (asked == kept).all()
    assert (arms[:, 1 - arm] == kept.reshape(arms.shape)[:, 1 - arm]).all()
    return arms[:, arm]
