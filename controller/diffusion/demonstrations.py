"""Convert a dataset of demonstrations to training data of the diffusion policy."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from controller.dataset.choice import ALL, Choice
from controller.dataset.dataset_episode import DatasetEpisode
from controller.dataset.reader import COPIES, read_episodes, sensed_copy
from controller.diffusion.displacement import free_and_near
from controller.diffusion.windows import DemonstrationArrays

COLUMNS = ("privileged.state", "action", "instruction", "expert", "segment", "seed")


def demonstrations(roots: Iterable[Path], choice: Choice = ALL) -> list[DemonstrationArrays]:
    """Return the chosen demonstrations of datasets.

    Raises:
        ValueError: As in `read_episodes`.
    """
    episodes = (episode for root in roots for episode in read_episodes(root, COLUMNS, choice))
    return [run for episode in episodes for copy in range(COPIES) for run in sensed(episode, copy)]


def sensed(episode: DatasetEpisode, copy: int) -> Iterator[DemonstrationArrays]:
    """Yield an episode, sensed with the errors of this copy and split at tool exchanges."""
    exact, actions, texts, expert, segment, seed = (episode.columns[name] for name in COLUMNS)
    states, (free, near) = sensed_copy(exact, int(seed[0]), copy), free_and_near(exact)
    for number in np.unique(segment):
        rows = segment == number
        yield DemonstrationArrays(
            states=states[rows],
            actions=actions[rows],
            texts=texts[rows].tolist(),
            expert=expert[rows],
            free=free[rows],
            near=near[rows],
        )
