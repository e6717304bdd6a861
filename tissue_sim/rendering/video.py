"""Write a video, picture by picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from tissue_sim.constants import CONTROL_HZ

QUALITY = 23  # libx264's constant rate factor: 0 is without loss, 51 the worst


class Video:
    """Writes pictures to a file in a `with` block; the file exists after the block."""

    def __init__(self, path: Path, keyframes: int = 250) -> None:
        """Write to `path`, with one keyframe in `keyframes` pictures; a low number speeds seeks."""
        self._path, self._partial = path, path.with_suffix(f".partial{path.suffix}")
        self._exact = ["-g", str(keyframes), "-bf", "0", "-crf", str(QUALITY)]

    def __enter__(self) -> Self:
        import imageio.v2 as imageio

        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._writer: Any = imageio.get_writer(
            self._partial,
            fps=CONTROL_HZ,
            codec="libx264",
            macro_block_size=2,
            output_params=self._exact,
        )
        return self

    def add(self, picture: NDArray[np.uint8]) -> None:
        """Add a picture (height, width, 3)."""
        self._writer.append_data(picture)

    def __exit__(self, *left: object) -> None:
        self._writer.close()
        if self._partial.exists():  # the file is made with the first picture
            self._partial.replace(self._path)
