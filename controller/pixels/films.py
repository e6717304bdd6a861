"""Convert a dataset with pictures to training data of the policy from pixels."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from controller.dataset.choice import ALL, Choice
from controller.dataset.filmed import read_filmed
from controller.diffusion.demonstrations import COLUMNS, sensed
from controller.diffusion.windows import DemonstrationArrays
from controller.pixels.config import PixelConfig


@dataclass(frozen=True, kw_only=True)
class Film:
    """A demonstration and its pictures.

    Attributes:
        demonstration: The demonstration, n control steps.
        pictures: (n, cameras, height, width, 3) pictures before each motion, shrunk.
    """

    demonstration: DemonstrationArrays
    pictures: NDArray[np.uint8]


def films(roots: Iterable[Path], config: PixelConfig, choice: Choice = ALL) -> list[Film]:
    """Return the chosen episodes of datasets with pictures.

    Raises:
        ValueError: As in `read_filmed`.
    """
    cameras, shrink = config.cameras, config.shrunk
    read = (e for root in roots for e in read_filmed(root, COLUMNS, cameras, shrink, choice))
    return [
        Film(demonstration=demonstration, pictures=pictures)
        for episode, pictures in read
        for demonstration in sensed(episode, copy=0)  # one: it is a stretch without an exchange
    ]
