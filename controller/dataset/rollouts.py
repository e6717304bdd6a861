"""Convert a dataset to training data of a planner: observations, given and right instructions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from controller.dataset.choice import ALL, Choice
from controller.dataset.dataset_episode import DatasetEpisode
from controller.dataset.reader import COPIES, read_episodes, sensed_copy
from controller.dataset.schema import NOT_FORKED
from planner.correction import CORRECTIONS
from planner.learned.rollout import NOT_SAID, Rollout
from planner.procedure.cholecystectomy import TASKS

COLUMNS = ("privileged.state", "task_index", "task", "flag", "correction", "seed", "forked_from")
OTHER_ORDERS = (
    "order",
    "turns",
    "fork",
    "forked-turns",
)  # of tubes, by an instruction that the planner cannot know
LEARNED, DECLINED = "rollout", "declined"
_CORRECTION = {c.text: k for k, c in enumerate(CORRECTIONS)}


def rollouts(roots: Iterable[Path], choice: Choice = ALL) -> list[Rollout]:
    """Return the chosen episodes of datasets in which the tubes were treated in the usual order.

    Raises:
        ValueError: As in `read_episodes`.
    """
    usual = replace(choice, leave_out=(*OTHER_ORDERS, *choice.leave_out))
    episodes = (episode for root in roots for episode in read_episodes(root, COLUMNS, usual))
    return [rollout_of(episode, copy) for episode in episodes for copy in range(COPIES)]


def rollout_of(episode: DatasetEpisode, copy: int = 0) -> Rollout:
    """Convert one episode, sensed with the errors of this copy."""
    unforked = episode.columns["forked_from"] == NOT_FORKED
    exact, heard, task, flag, wanted, seed = (episode.columns[k][unforked] for k in COLUMNS[:-1])
    corrected = heard >= len(TASKS)
    names = np.where(flag, wanted, "")
    return Rollout(
        states=sensed_copy(exact, int(seed[0]), copy),
        said=_task_said(heard, corrected, task - 1),
        corrected=np.where(corrected, heard - len(TASKS), NOT_SAID),
        task=task - 1,
        correction=np.array([_CORRECTION.get(name, NOT_SAID) for name in names]),
        success=episode.header.success and episode.header.kind != DECLINED,
        declined=episode.header.kind == DECLINED,
        learned=episode.header.kind.partition(":")[0] == LEARNED,
        patient=int(seed[0]),
    )


def _task_said(
    heard: NDArray[np.int64], corrected: NDArray[np.bool_], task: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the task given in each frame; during a correction, the last task before it."""
    rows = np.where(corrected, -1, np.arange(len(heard)))
    last = np.maximum.accumulate(rows)
    return np.where(last < 0, task, heard[np.maximum(last, 0)])
