"""Random orders of the procedure, so that instructions decide which tube is next."""

from __future__ import annotations

import numpy as np

from planner.instruction import TASKS, Task

_OF_TUBE = 8  # three clips and a cut, each followed by a retraction


def shuffled_order(rng: np.random.Generator) -> tuple[Task, ...]:
    """Draw an order: grab first; each tube's clips and cut keep their order, the tubes mix.

    The last task is the last of the usual order.
    """
    left, right = list(TASKS[1 : 1 + _OF_TUBE]), list(TASKS[1 + _OF_TUBE :])
    order = [TASKS[0]]
    while left or right:
        of_tube = left if not right or (left and rng.random() < 0.5) else right
        order += of_tube[:2]
        del of_tube[:2]
    return (*order, TASKS[-1])
