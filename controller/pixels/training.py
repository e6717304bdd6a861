"""Train the policy from pixels; a stopped training resumes exactly.

The training is that of the diffusion controller, but without displaced tools: a picture would not
show the displacement.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from hashlib import sha256
from typing import ClassVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional as F

from controller.diffusion.command import sentences
from controller.diffusion.training import kept_commands, noise_for
from controller.diffusion.windows import Windows
from controller.pixels.config import CAMERAS, CHUNKS, PixelConfig
from controller.pixels.films import Film
from controller.pixels.policy import CHECKPOINTS, PixelPolicy, of_tools
from planner.learning.optimise import Schedule, learn

CHECKPOINT_FILE = CHECKPOINTS.shipped.name
NORMALISE_BY = 2_000  # windows
SHIFT_PX = 4  # the most by which pictures are shifted (Yarats et al., arXiv 2004.13649)


@dataclass(frozen=True, kw_only=True)
class PixelTraining(Schedule):
    """The settings of a policy's training.

    Attributes:
        noises: Noisy chunks per window; pictures cost much more.
    """

    policy: PixelConfig = field(default_factory=PixelConfig)
    shape_of: ClassVar[str] = "pixels"
    steps: int = 12_000
    batch: int = 64
    noises: int = 8


PRESETS = {
    "full": PixelTraining(),
    "smoke": PixelTraining(
        policy=PixelConfig(
            cameras=CAMERAS[:1],
            shrink=8,
            widths=(8, 8, 8, 8),
            chunks=replace(
                CHUNKS, condition_width=64, condition_blocks=1, denoiser_width=64, denoiser_blocks=1
            ),
        ),
        steps=60,
        batch=32,
        warm_up=10,
        average=0.9,
        save_every=20,
    ),
}


class FilmData:
    """All windows, the pictures of all frames, and the sentences' embeddings.

    Attributes:
        digest: Digest of all training data, in hex.
    """

    def __init__(self, films: Sequence[Film], config: PixelTraining, device: str) -> None:
        self._config, chunks = config, config.policy.chunks
        heard = [film.demonstration.heard_by(chunks) for film in films]
        self.windows = Windows(heard, chunks, device)
        self._pictures = [film.pictures for film in films]  # not joined: that would need them twice
        self._ends = np.cumsum([len(pictures) for pictures in self._pictures])
        self.digest = _digest(self.windows, self._pictures)
        self._sentences = [said.to(device) for said in sentences(chunks)]

    def shown(self, newest: Tensor) -> Tensor:
        """Return the pictures (B, cameras, height, width, 3) of these frames."""
        rows = newest.cpu().numpy()
        which = np.searchsorted(self._ends, rows, side="right")
        shown = [self._pictures[k][row - self._ends[k]] for k, row in zip(which, rows, strict=True)]
        return torch.from_numpy(np.stack(shown)).to(newest.device)

    def normalise(self, policy: PixelPolicy, chance: torch.Generator) -> None:
        """Set the normalisation; codes of pictures, of order one, keep their own."""
        which = self.windows.some(NORMALISE_BY, chance)
        seen = self.windows.batch(which, torch.zeros_like(which))
        tools = of_tools(seen.history[:, 0], seen.jaw_rad)
        policy.normalise_by(F.pad(tools, (0, policy.pictures.size)), seen)
        policy.feature_deviation[-policy.pictures.size :] = 1.0

    def loss(self, policy: PixelPolicy, chance: torch.Generator) -> Tensor:
        """Return the loss of random windows, shifts, noises and noise levels."""
        which = self.windows.balanced(self._config.batch, chance)
        seen = self.windows.batch(which, torch.zeros_like(which))
        pictures = shifted(self.shown(seen.newest), chance)
        level, noise = noise_for(seen.chunk, self._config.noises, chance)
        kept = kept_commands(self._config.batch, chance)
        enabled = self._config.bfloat16
        with torch.autocast(chance.device.type, torch.bfloat16, enabled=enabled):
            features = policy.features(pictures, seen.history[:, 0], seen.jaw_rad)
            return policy.loss(features, seen, self._sentences, kept, level, noise)


train = partial(learn, FilmData, CHECKPOINTS)  # (films, config, out, device, base)


def _digest(windows: Windows, pictures: Sequence[NDArray[np.uint8]]) -> str:
    digest = sha256(windows.digest.encode())
    for shown in pictures:
        digest.update(np.ascontiguousarray(shown).data)
    return digest.hexdigest()


def shifted(pictures: Tensor, chance: torch.Generator) -> Tensor:
    """Return pictures (B, cameras, height, width, 3), each window's shifted by some pixels.

    Pixels that come in at an edge repeat the edge.
    """
    B, _, height, width, _ = pictures.shape
    rows, columns = (torch.arange(n, device=pictures.device) for n in (height, width))
    most = 2 * SHIFT_PX + 1
    offs = torch.randint(most, (B, 2, 1), generator=chance, device=chance.device) - SHIFT_PX
    y, x = (rows + offs[:, 0]).clamp(0, height - 1), (columns + offs[:, 1]).clamp(0, width - 1)
    each = zip(pictures, y, x, strict=True)
    return torch.stack([picture[:, down][:, :, along] for picture, down, along in each])
