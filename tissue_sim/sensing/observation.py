"""What a policy may see: tools, tracked tissue points, clips, forces. Never the hidden state."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array

TUBE_POINTS = 8  # tracked points along each tube, from the fixed end up
SAC_POINTS = 5  # along the infundibulum, from the neck up
MAX_CLIPS = 8


@dataclass(frozen=True, kw_only=True)
class Observation:
    """One control step's view. Rows: left, right arm. Frame: endoscope (+x left, +y up, +z away).

    Attributes:
        time_s: since the episode's start.
        joints: (2, 7) measured: yaw, pitch, insertion (m), roll, wrist pitch, wrist yaw, jaw.
        tips_endoscope: (2, 4, 4) `T_endoscope_tool`.
        forces_n: (2, 3) what the tissue does to each tool.
        tools: names of the mounted instruments.
        clip_loaded: the applier holds a clip.
        left_tube_m, right_tube_m: (8, 3) centreline points of the tubes as seen.
        sac_m: (5, 3) axis of the infundibulum.
        clips_m: (8, 3) clips in order of closing, zeros beyond `n_clips`.
        severed: (2,) left and right tube seen in two parts.
        images: camera name -> (height, width, 3) uint8, where a renderer exists.
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
        """Everything but the images as one flat vector (`VECTOR_SIZE`,)."""
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
"""What stands where in `Observation.vector()`."""

VECTOR_SIZE = sum(prod(shape) for shape in VECTOR_LAYOUT.values())


def fields(vectors: Any) -> dict[str, Any]:
    """The parts of vectors (..., `VECTOR_SIZE`), arrays or tensors, each (..., *shape)."""
    parts, at = {}, 0
    for name, shape in VECTOR_LAYOUT.items():
        size = prod(shape)
        parts[name] = vectors[..., at : at + size].reshape(*vectors.shape[:-1], *shape)
        at += size
    return parts
