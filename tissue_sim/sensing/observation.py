"""What a policy is told in each control step: tools, points of the tissue, clips, forces.

The values are exact simulator state today (`exact.py`). Anything else in the simulator is hidden.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array

TUBE_POINTS = 8  # along each tube, from the fixed end up
SAC_POINTS = 5  # along the infundibulum, from the neck up
MAX_CLIPS = 8


@dataclass(frozen=True, kw_only=True)
class Observation:
    """One control step. Rows: left, right arm. Frame: endoscope (+x left, +y up, +z away).

    Attributes:
        time_s: since the episode's start.
        joints: (2, 7) now: yaw, pitch, insertion (m), roll, wrist pitch, wrist yaw, jaw (rad).
        tips_endoscope: (2, 4, 4) `T_endoscope_tool`.
        forces_n: (2, 3) force of the tissue on each tool.
        tools: names of the mounted instruments.
        clip_loaded: the applier holds a clip.
        left_tube_m, right_tube_m: (8, 3) points of the tubes' centrelines, named by where the
            endoscope shows them.
        sac_m: (5, 3) axis of the infundibulum.
        clips_m: (8, 3) clips in order of closing, zeros beyond `n_clips`.
        severed: (2,) whether the left and the right tube are cut or torn through.
        images: camera name -> (height, width, 3) uint8, where they were drawn.
    """

    time_s: float
    joints: Array
    tips_endoscope: Array
    forces_n: Array
    tools: tuple[str, str]
    clip_loaded: bool
    left_tube_m: Array
    right_tube_m: Array
    sac_m: Array
    clips_m: Array
    n_clips: int
    severed: NDArray[np.bool_]
    images: dict[str, NDArray[np.uint8]] = field(default_factory=dict)

    def vector(self) -> NDArray[np.float32]:
        """Flatten everything but time, images and the left tool into (`VECTOR_SIZE`,)."""
        parts = (
            self.joints, self.tips_endoscope[:, :3], self.forces_n, self.left_tube_m,
            self.right_tube_m, self.sac_m, self.clips_m,
            [self.n_clips, self.clip_loaded, self.tools[1] == "scissors"], self.severed,
        )  # fmt: skip
        return np.concatenate([np.ravel(p) for p in parts]).astype(np.float32)


VECTOR_LAYOUT: dict[str, tuple[int, ...]] = {
    "joints": (2, 7),
    "tips_endoscope": (2, 3, 4),
    "forces_n": (2, 3),
    "left_tube_m": (TUBE_POINTS, 3),
    "right_tube_m": (TUBE_POINTS, 3),
    "sac_m": (SAC_POINTS, 3),
    "clips_m": (MAX_CLIPS, 3),
    "n_clips": (1,),
    "clip_loaded": (1,),
    "scissors": (1,),
    "severed": (2,),
}
"""Order and shapes of the parts of `Observation.vector()`."""

VECTOR_SIZE = sum(prod(shape) for shape in VECTOR_LAYOUT.values())


def fields(vectors: Any) -> dict[str, Any]:
    """Split vectors (..., `VECTOR_SIZE`), arrays or tensors, into views (..., *shape) by name."""
    parts, at = {}, 0
    for name, shape in VECTOR_LAYOUT.items():
        size = prod(shape)
        parts[name] = vectors[..., at : at + size].reshape(*vectors.shape[:-1], *shape)
        at += size
    return parts
