"""Train the diffusion policy; a stopped training resumes exactly. Read the file top to bottom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import torch
from torch import Tensor

from controller.diffusion.command import sentences
from controller.diffusion.config import PolicyConfig
from controller.diffusion.displacement import arrived, displaced, half_shut
from controller.diffusion.policy import CHECKPOINTS, Policy
from controller.diffusion.windows import DemonstrationArrays, Windows
from planner.learning.optimise import Schedule, learn

CHECKPOINT_FILE = CHECKPOINTS.shipped.name
NORMALISE_BY = 20_000  # windows
DROPPED = 0.15  # share of windows without a command, for guidance and for the state alone
MIN_LEVEL = 0.02  # of noise: below it there is nothing to learn


@dataclass(frozen=True, kw_only=True)
class TrainingConfig(Schedule):
    """The settings of a policy's training.

    Attributes:
        noises: Noisy chunks per window; conditions cost more (Mini-Diffuser, arXiv 2505.09430).
    """

    policy: PolicyConfig = field(default_factory=PolicyConfig)
    steps: int = 45_000
    noises: int = 2


PRESETS = {
    "full": TrainingConfig(),
    "smoke": TrainingConfig(
        policy=PolicyConfig(
            condition_width=64, condition_blocks=1, denoiser_width=64, denoiser_blocks=1
        ),
        steps=60,
        batch=64,
        warm_up=10,
        average=0.9,
        save_every=20,
    ),
}


class PolicyData:
    """All windows, and the sentences' embeddings.

    Attributes:
        digest: Digest of all training data, in hex.
    """

    def __init__(
        self, demonstrations: Sequence[DemonstrationArrays], config: TrainingConfig, device: str
    ) -> None:
        self._config = config
        heard = [d.heard_by(config.policy) for d in demonstrations]
        self._windows = Windows(heard, config.policy, device)
        self.digest = self._windows.digest
        self._sentences = [said.to(device) for said in sentences(config.policy)]

    def normalise(self, policy: Policy, chance: torch.Generator) -> None:
        """Set the normalisation from some windows."""
        some = self._windows.some(NORMALISE_BY, chance)
        seen = self._windows.batch(some, torch.zeros_like(some))
        policy.normalise_by(policy.features(seen.history, seen.jaw_rad), seen)

    def loss(self, policy: Policy, chance: torch.Generator) -> Tensor:
        """Return the loss of random windows, noises, noise levels and delays."""
        device, config = chance.device, self._config
        which = self._windows.balanced(config.batch, chance)
        most = config.policy.max_delay + 1
        delay = torch.randint(most, (config.batch,), generator=chance, device=device)
        batch = self._windows.batch(which, delay)
        batch = arrived(displaced(half_shut(batch, chance), chance), chance)
        level, noise = noise_for(batch.chunk, config.noises, chance)
        kept = kept_commands(config.batch, chance)
        with torch.autocast(device.type, torch.bfloat16, enabled=config.bfloat16):  # poses: float32
            features = policy.features(batch.history, batch.jaw_rad)
            return policy.loss(features, batch, self._sentences, kept, level, noise)


def kept_commands(n: int, chance: torch.Generator) -> Tensor:
    """Return (n, 1): 1, or 0 for a command that is dropped."""
    return (torch.rand(n, 1, generator=chance, device=chance.device) >= DROPPED).float()


train = partial(learn, PolicyData, CHECKPOINTS)  # (demonstrations, config, out, device, base)


def noise_for(chunk: Tensor, n: int, chance: torch.Generator) -> tuple[Tensor, Tensor]:
    """Return n random levels (B, n), and noise (B, n, H, 20), for each chunk (B, H, 20)."""
    shape = len(chunk), n
    level = torch.rand(shape, generator=chance, device=chance.device)
    noise = torch.randn(*shape, *chunk.shape[1:], generator=chance, device=chance.device)
    return MIN_LEVEL + (1.0 - MIN_LEVEL) * level, noise
