"""A dataset as a planner learns from it: what was seen and said, and what should have been said."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from controller.dataset.dataset_episode import DatasetEpisode
from controller.dataset.reader import read_episodes
from planner.correction import CORRECTIONS
from planner.learned.rollout import NOT_SAID, Rollout
from planner.task import TASKS

COLUMNS = ("observation.state", "task_index", "task", "flag", "correction")
OTHER_ORDERS = ("order", "turns")  # of tubes, by an instruction that a planner does not know
LEARNED = "rollout"
_CORRECTION = {c.text: k for k, c in enumerate(CORRECTIONS)}


def rollouts(roots: Iterable[Path], leave_out: Collection[str] = ()) -> list[Rollout]:
    """All of the datasets in these folders in which the tubes were taken in their order.

    Or all of them but those of some kinds, "recovery" say.

    Raises:
        ValueError: as of `read_episodes`, in one line.
    """
    left_out = (*OTHER_ORDERS, *leave_out)
    episodes = (episode for root in roots for episode in read_episodes(root, COLUMNS))
    return [rollout_of(e) for e in episodes if _kind(e) not in left_out]


def rollout_of(episode: DatasetEpisode) -> Rollout:
    """One episode."""
    states, heard, task, flag, wanted = (episode.columns[name] for name in COLUMNS)
    corrected = heard >= len(TASKS)
    names = np.where(flag, wanted, "")
    return Rollout(
        states=states,
        said=_task_said(heard, corrected, task - 1),
        corrected=np.where(corrected, heard - len(TASKS), NOT_SAID),
        task=task - 1,
        correction=np.array([_CORRECTION.get(name, NOT_SAID) for name in names]),
        success=episode.header.success,
        learned=_kind(episode) == LEARNED,
    )


def _kind(episode: DatasetEpisode) -> str:
    return episode.header.kind.partition(":")[0]


def _task_said(
    heard: NDArray[np.int64], corrected: NDArray[np.bool_], task: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Under a correction, the task that was said last before it."""
    rows = np.where(corrected, -1, np.arange(len(heard)))
    last = np.maximum.accumulate(rows)
    return np.where(last < 0, task, heard[np.maximum(last, 0)])
