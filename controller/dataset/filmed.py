"""Read the episodes of a dataset with the pictures that its cameras filmed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controller.dataset import layout
from controller.dataset.choice import ALL, Choice
from controller.dataset.dataset_episode import DatasetEpisode
from controller.dataset.reader import read_episodes, read_rows, require_dataset
from controller.dataset.schema import FPS, PICTURES
from controller.dataset.videos import pictures

Shrink = Callable[[NDArray[np.uint8]], NDArray[np.uint8]]


def read_filmed(
    root: Path,
    columns: Sequence[str],
    cameras: Sequence[str],
    shrink: Shrink,
    choice: Choice = ALL,
) -> Iterator[tuple[DatasetEpisode, NDArray[np.uint8]]]:
    """Yield chosen episodes in their order, with pictures (n, cameras, height, width, 3).

    Args:
        root: Folder of the dataset.
        columns: Columns to read.
        cameras: Cameras whose pictures are returned, in this order.
        shrink: Makes a picture (240, 320, 3) smaller as soon as the picture is read.
        choice: The choice of episodes.

    Raises:
        ValueError: A camera did not film; else as in `read_episodes` and `pictures`.
    """
    there = require_dataset(root)
    if missing := [camera for camera in cameras if camera not in there]:
        filmed = ", ".join(there) or "none"
        raise ValueError(f"{root}: {', '.join(missing)} did not film; cameras are: {filmed}")
    shown = [_Films(root, camera, shrink) for camera in cameras]
    rows = read_rows(root, [column for films in shown for column in films.columns])
    chosen = [row for row, taken in zip(rows, choice.of(rows), strict=True) if taken]
    for row, episode in zip(chosen, read_episodes(root, columns, choice), strict=True):
        yield episode, np.stack([films.of(row) for films in shown], axis=1)


class _Films:
    """Reads the pictures of one camera; the videos are read one after another, each once.

    Attributes:
        columns: Columns of an episode's row that say where the episode's pictures are.
    """

    def __init__(self, root: Path, camera: str, shrink: Shrink) -> None:
        names = ("chunk_index", "file_index", "from_timestamp", "to_timestamp")
        self.columns = [f"videos/{PICTURES}{camera}/{name}" for name in names]
        self._root, self._camera, self._shrink = root, camera, shrink
        self._file, self._next = -1, 0

    def of(self, row: Mapping[str, Any]) -> NDArray[np.uint8]:
        """Return the pictures (n, height, width, 3) of the episode with this row."""
        chunk, within, *times_s = (row[column] for column in self.columns)
        file = layout.FILES_A_CHUNK * chunk + within
        first, end = (round(time_s * FPS) for time_s in times_s)
        path = self._root / layout.video_path(self._camera, file)
        if file != self._file:
            self._file, self._next, self._video = file, 0, pictures(path)
        taken = islice(self._video, first - self._next, end - self._next)
        self._next, shown = end, [self._shrink(picture) for picture in taken]
        if len(shown) != end - first:
            raise ValueError(f"{path}: it ends before its picture {end}")
        return np.stack(shown)
