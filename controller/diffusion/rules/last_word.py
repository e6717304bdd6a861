"""The rules that change a chunk as it is made, in their order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from controller.diffusion.rules.centring import centred
from controller.diffusion.rules.closing import closed_in_place
from controller.diffusion.rules.grasping import grasped_on
from controller.diffusion.rules.reaching import reached
from controller.diffusion.rules.retreating import drawn_back
from controller.diffusion.rules.squaring import squared
from controller.diffusion.rules.waiting import waited
from planner.task import Task
from tissue_sim.frames import Array

RULES = squared, grasped_on, waited, reached, centred, drawn_back


def last_word(chunk: Array, seen: NDArray[np.float32], task: Task, jaws_rad: Array) -> Array:
    """Return a chunk (n, 20) with what the rules of its task change.

    Args:
        chunk: as `chunk_frame` has it; not changed.
        seen: `Observation.vector()` at its start.
        task: the running one.
        jaws_rad: (m, 2) commanded before it, the last one last.
    """
    for rule in RULES:
        chunk = rule(chunk, seen, task)
    return closed_in_place(chunk, seen, task, jaws_rad)
