"""Define the configuration of a policy from pixels, which is saved in the checkpoint."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from controller.dataset.schema import PICTURE_SHAPE
from controller.diffusion.config import PolicyConfig
from planner.learning.networks import Channels

CAMERAS = ("endoscope_left", "wrist_left", "wrist_right")
CHUNKS = PolicyConfig(history=(0,), play=8, max_delay=0)


@dataclass(frozen=True, kw_only=True)
class PixelConfig:
    """Cameras and shapes of a policy.

    Attributes:
        cameras: Cameras whose pictures the policy observes.
        shrink: Number of pixels of a picture that become one pixel, along each axis.
        widths: Channels of the convolutions.
        chunks: Configuration of the diffusion. The policy observes the present frame only, when a
            chunk begins.

    Raises:
        ValueError: There is no camera, pictures cannot be shrunk so, or frames of the past are
            requested.
    """

    cameras: tuple[str, ...] = CAMERAS
    shrink: int = 2
    widths: tuple[Channels, Channels, Channels, Channels] = (16, 32, 64, 64)
    chunks: PolicyConfig = field(default_factory=lambda: CHUNKS)

    def __post_init__(self) -> None:
        if not self.cameras:
            raise ValueError("cameras must name at least one")
        if self.shrink < 1 or any(size % self.shrink for size in PICTURE_SHAPE[:2]):
            raise ValueError(f"shrink must divide {PICTURE_SHAPE[:2]}, got {self.shrink}")
        if self.chunks.history != (0,) or self.chunks.max_delay:
            raise ValueError("chunks must have history (0,) and max_delay 0")

    def shrunk(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return a picture (height, width, 3) at its smaller size, the mean of its pixels."""
        n = self.shrink
        total = np.full_like(picture[::n, ::n], n**2 // 2, np.uint16)
        for row, column in np.ndindex(n, n):
            total += picture[row::n, column::n]
        return (total // n**2).astype(np.uint8)
