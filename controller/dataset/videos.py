"""Read the videos of an episode: one per camera, with a picture before each frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import imageio.v3 as imageio
import numpy as np
from numpy.typing import NDArray

from controller.dataset.part import one_line
from controller.dataset.schema import PICTURE_SHAPE
from controller.dataset.statistics import Statistics, statistics_of_rows

EVERY = 30  # pictures from one that counts for the statistics to the next: one a second


def pictures(path: Path) -> Iterator[NDArray[np.uint8]]:
    """Yield the pictures of a video (height, width, 3).

    Raises:
        ValueError: The file is missing or damaged, or of another size. The message is one line.
    """
    try:
        for picture in imageio.imiter(path, plugin="FFMPEG"):
            if picture.shape != PICTURE_SHAPE:
                raise ValueError(f"its pictures are {picture.shape}, not {PICTURE_SHAPE}")
            yield picture
    except (OSError, ValueError, RuntimeError) as error:
        raise ValueError(f"{path}: {one_line(error)}") from error


def picture_statistics(path: Path, frames: int, stretches: Sequence[slice]) -> list[Statistics]:
    """Return for each stretch the statistics of the channels, 0 to 1.

    The statistics cover every `EVERY`-th picture of the stretch; the video is read once.

    Raises:
        ValueError: As in `pictures`, or there are more or fewer than `frames` pictures.
    """
    counted = {k for stretch in stretches for k in range(stretch.start, stretch.stop, EVERY)}
    taken, n = dict[int, NDArray[np.uint8]](), 0
    for n, picture in enumerate(pictures(path), start=1):
        if n - 1 in counted:
            taken[n - 1] = picture
    if n != frames:
        raise ValueError(f"{path}: it has {n} pictures of {frames} frames")
    shown = ([taken[k] for k in range(s.start, s.stop, EVERY)] for s in stretches)
    channels = PICTURE_SHAPE[2]
    return [statistics_of_rows(np.concatenate(s).reshape(-1, channels) / 255.0) for s in shown]
