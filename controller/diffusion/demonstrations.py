"""Convert a dataset of demonstrations to training data of the diffusion policy."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from controller.dataset.choice import ALL, Choice
from controller.dataset.dataset_episode import DatasetEpisode
from controller.dataset.reader import COPIES, forks_in, read_episodes, sensed_copy
from controller.dataset.schema import NOT_FORKED, UNNAMED
from controller.diffusion.command import NONE
from controller.diffusion.displacement import free_and_near
from controller.diffusion.windows import DemonstrationArrays
from planner.procedure.cholecystectomy import TASKS

COLUMNS = (
    "privileged.state",
    "action",
    "task_index",
    "task",
    "left",
    "expert",
    "segment",
    "forked_from",
    "seed",
)
BEFORE_FORK = 8  # steps before a fork that are its past


def demonstrations(roots: Iterable[Path], choice: Choice = ALL) -> list[DemonstrationArrays]:
    """Return the chosen demonstrations of datasets.

    Raises:
        ValueError: As in `read_episodes`.
    """
    episodes = (episode for root in roots for episode in read_episodes(root, COLUMNS, choice))
    return [run for episode in episodes for copy in range(COPIES) for run in sensed(episode, copy)]


def sensed(episode: DatasetEpisode, copy: int) -> Iterator[DemonstrationArrays]:
    """Yield an episode, sensed with the errors of this copy and split at tool exchanges.

    Forks follow, each after the steps of the episode before it. Only the first copy has them.
    """
    exact, actions, heard, task, left, expert, segment, forked_from, seed = (
        episode.columns[name] for name in COLUMNS
    )
    own, forks = forked_from == NOT_FORKED, [] if copy else forks_in(forked_from, segment)
    tracked = exact[own] if copy else exact
    states = sensed_copy(tracked, int(seed[0]), copy, forks)
    free, near = free_and_near(exact)
    corrected = heard >= len(TASKS)
    correction = np.where(corrected, heard - len(TASKS), NONE)
    left = np.where(corrected[:, None], left, np.float32(UNNAMED))  # not that of a label
    stretches = (np.flatnonzero(own & (segment == k)) for k in np.unique(segment[own]))
    runs = [(rows[:0], rows) for rows in stretches]
    runs += [(_before(fork.begins, segment), np.array(fork.rows)) for fork in forks]
    for before, imitated in runs:
        rows = np.concatenate([before, imitated])
        yield DemonstrationArrays(
            states=states[rows],
            actions=actions[rows],
            task=task[rows] - 1,
            correction=correction[rows],
            left=left[rows],
            expert=expert[rows],
            free=free[rows],
            near=near[rows],
            begins=len(before),
        )


def _before(fork: int, segment: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the last rows before a fork, of the segment that the fork continues."""
    rows = np.arange(max(fork - BEFORE_FORK, 0), fork)
    return rows[segment[rows] == segment[fork - 1]]
