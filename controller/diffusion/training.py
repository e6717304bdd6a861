"""Train the diffusion policy; a stopped training resumes exactly. Read the file top to bottom."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import torch
from torch import Tensor

from controller.diffusion.config import PolicyConfig
from controller.diffusion.displacement import displaced, half_shut
from controller.diffusion.policy import CHECKPOINTS, Policy
from controller.diffusion.windows import DemonstrationArrays, Windows
from planner.correction import CORRECTIONS
from planner.language.sentence_encoder import embed_all
from planner.learning.optimise import Schedule, TrainingStep, fine_tuning_schedule, optimise

CHECKPOINT_FILE = "policy.safetensors"
NORMALISE_BY = 20_000  # windows
JAWS_ASKED = frozenset(c.text for c in CORRECTIONS if c.jaw)
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


def fine_tuning(config: TrainingConfig, base: Path) -> tuple[TrainingConfig, Policy]:
    """Return the configuration for fine-tuning a checkpoint, and the checkpoint's policy.

    Raises:
        CheckpointError: As in `Checkpoints.load`.
    """
    policy = CHECKPOINTS.load(base)
    return replace(fine_tuning_schedule(base, config), policy=policy.config), policy


def train(
    demonstrations: Sequence[DemonstrationArrays],
    config: TrainingConfig,
    out: Path,
    device: str = "cpu",
    base: Policy | None = None,
) -> Iterator[TrainingStep]:
    """Train a policy, or resume the training in `out`; write checkpoint and state to `out`.

    A new training starts from `base`, if given, and keeps its normalisation.

    Raises:
        ValueError: There is no motion to imitate, or `out` holds the training of another
            configuration or on other demonstrations. Nothing is changed.
    """
    torch.manual_seed(config.seed)
    chance = torch.Generator(device).manual_seed(config.seed)
    heard = [d.heard_by(config.policy) for d in demonstrations]
    windows = Windows(heard, config.policy, device)
    words = embed_all(windows.texts).to(device)
    asked = torch.tensor([text in JAWS_ASKED for text in windows.texts], device=device)
    policy = Policy(config.policy).to(device)
    if base is None:
        some = torch.randint(len(windows), (NORMALISE_BY,), generator=chance, device=device)
        seen = windows.batch(some, torch.zeros_like(some))
        policy.normalise_by(policy.features(seen.history, seen.jaw_rad), seen)
    else:
        policy.load_state_dict(base.state_dict())
    yield from optimise(
        policy,
        partial(_loss, windows=windows, words=words, asked=asked, chance=chance, config=config),
        chance,
        config,
        out,
        windows.digest,
        out / CHECKPOINT_FILE,
        CHECKPOINTS.save,
    )


def _loss(
    policy: Policy,
    windows: Windows,
    words: Tensor,
    asked: Tensor,
    chance: torch.Generator,
    config: TrainingConfig,
) -> Tensor:
    """Return the loss of random windows, noises, noise levels and delays."""
    device = chance.device
    which = torch.randint(len(windows), (config.batch,), generator=chance, device=device)
    most = config.policy.max_delay + 1
    delay = torch.randint(most, (config.batch,), generator=chance, device=device)
    batch = windows.batch(which, delay)
    batch = displaced(half_shut(batch, asked[batch.text], chance), chance)
    level, noise = noise_for(batch.chunk, config.noises, chance)
    with torch.autocast(device.type, torch.bfloat16, enabled=config.bfloat16):  # poses need float32
        features = policy.features(batch.history, batch.jaw_rad)
        return policy.loss(features, batch, words, level, noise)


def noise_for(chunk: Tensor, n: int, chance: torch.Generator) -> tuple[Tensor, Tensor]:
    """Return n random levels (B, n), and noise (B, n, H, 20), for each chunk (B, H, 20)."""
    shape = len(chunk), n
    level = torch.rand(shape, generator=chance, device=chance.device)
    noise = torch.randn(*shape, *chunk.shape[1:], generator=chance, device=chance.device)
    return MIN_LEVEL + (1.0 - MIN_LEVEL) * level, noise
