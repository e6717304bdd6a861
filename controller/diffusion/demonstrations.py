"""A dataset of demonstrations as training data of the diffusion policy."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from pathlib import Path

import numpy as np

from controller.dataset.dataset_episode import DatasetEpisode
from controller.dataset.reader import read_episodes
from controller.diffusion.windows import DemonstrationArrays

COLUMNS = ("observation.state", "action", "instruction", "expert", "segment")


def demonstrations(
    roots: Iterable[Path], leave_out: Container[str] = ()
) -> list[DemonstrationArrays]:
    """Return the demonstrations of datasets, without those of the kinds in `leave_out`.

    Raises:
        ValueError: as `read_episodes` does.
    """
    episodes = (episode for root in roots for episode in read_episodes(root, COLUMNS))
    return list(unbroken(e for e in episodes if e.header.kind.partition(":")[0] not in leave_out))


def unbroken(episodes: Iterable[DatasetEpisode]) -> Iterator[DemonstrationArrays]:
    """Split episodes where tools were exchanged."""
    for episode in episodes:
        states, actions, texts, expert, segment = (episode.columns[name] for name in COLUMNS)
        for number in np.unique(segment):
            rows = segment == number
            yield DemonstrationArrays(
                states=states[rows],
                actions=actions[rows],
                texts=texts[rows].tolist(),
                expert=expert[rows],
            )
