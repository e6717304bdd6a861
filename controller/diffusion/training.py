"""Training of the diffusion policy, to be read from top to bottom; it resumes exactly."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import cast

import torch
from torch import Tensor

from controller.diffusion.checkpoint import load_checkpoint, save_checkpoint
from controller.diffusion.config import PolicyConfig
from controller.diffusion.policy import Policy
from controller.diffusion.tracker_noise import noised
from controller.diffusion.windows import Demonstration, Windows
from planner.language.sentence_encoder import embed_all

STATE_FILE, CHECKPOINT_FILE, LOG_FOLDER = "training.pt", "policy.safetensors", "tensorboard"
NORMALISE_BY = 20_000  # windows
LEAST_LEVEL = 0.02  # of noise: below it there is nothing to learn
GRADIENT_MOST = 1.0
FINE_TUNING_SHARE = 0.3  # of the learning rate


@dataclass(frozen=True, kw_only=True)
class TrainingConfig:
    """How a policy is trained.

    Attributes:
        steps: of the optimiser.
        batch: windows a step.
        noises: noisy chunks a window, as conditions cost more (Mini-Diffuser, arXiv 2505.09430).
        learning_rate: highest; it rises over `warm_up` steps and falls to zero as a cosine.
        average: decay of the weights' moving average, which is what is saved.
        save_every: steps.
        bfloat16: multiply matrices in it: half again as fast where the processor can.
        base: digest of the checkpoint that is gone on from; "" to begin anew.
    """

    policy: PolicyConfig = field(default_factory=PolicyConfig)
    steps: int = 45_000
    batch: int = 512
    noises: int = 2
    learning_rate: float = 1e-3
    weight_decay: float = 1e-4
    warm_up: int = 300
    average: float = 0.999
    save_every: int = 1000
    seed: int = 0
    bfloat16: bool = False
    base: str = ""


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
    """How a checkpoint is gone on from, and its policy.

    Raises:
        CheckpointError: as of `load_checkpoint`.
    """
    policy = load_checkpoint(base)
    config = replace(
        config,
        policy=policy.config,
        learning_rate=FINE_TUNING_SHARE * config.learning_rate,
        base=sha256(base.read_bytes()).hexdigest(),
    )
    return config, policy


@dataclass(frozen=True, kw_only=True)
class TrainingStep:
    """A step done, and the loss of its batch."""

    step: int
    loss: float


def train(
    demonstrations: Sequence[Demonstration],
    config: TrainingConfig,
    out: Path,
    device: str = "cpu",
    base: Policy | None = None,
) -> Iterator[TrainingStep]:
    """Train from where `out` has got to, or anew; leave there checkpoint and what resuming needs.

    Begun anew, it goes on from `base` if there is one, whose normalisation is kept.

    Raises:
        ValueError: there is nothing to learn from, or `out` holds the training of another
            configuration or of other demonstrations; nothing is changed.
    """
    from torch.utils.tensorboard.writer import SummaryWriter

    torch.manual_seed(config.seed)
    chance = torch.Generator(device).manual_seed(config.seed)
    windows = Windows(demonstrations, config.policy, device)
    words = embed_all(windows.texts).to(device)
    policy = Policy(config.policy).to(device)
    if base is None:
        some = torch.randint(len(windows), (NORMALISE_BY,), generator=chance, device=device)
        policy.normalise_by(windows.batch(some, torch.zeros_like(some)))
    else:
        policy.load_state_dict(base.state_dict())
    average = torch.optim.swa_utils.AveragedModel(
        policy, multi_avg_fn=torch.optim.swa_utils.get_ema_multi_avg_fn(config.average)
    )
    optimiser = torch.optim.AdamW(
        policy.parameters(),
        lr=config.learning_rate,
        weight_decay=config.weight_decay,
        fused=True,  # unfused, denormal moments make it slow on a CPU
    )
    parts = {"policy": policy, "average": average, "optimiser": optimiser}
    begin = _resume(out / STATE_FILE, parts, chance, config, windows.digest)
    with SummaryWriter(out / LOG_FOLDER, purge_step=begin) as log:
        for step in range(begin, config.steps):
            rate = config.learning_rate * _share(step, config)
            for group in optimiser.param_groups:
                group["lr"] = rate
            loss = _loss(policy, windows, words, chance, config)
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(policy.parameters(), GRADIENT_MOST)
            optimiser.step()
            average.update_parameters(policy)
            log.add_scalar("loss", loss.item(), step)
            log.add_scalar("learning rate", rate, step)
            if (step + 1) % config.save_every == 0 or step + 1 == config.steps:
                save_checkpoint(out / CHECKPOINT_FILE, cast(Policy, average.module))
                _save(out / STATE_FILE, parts, chance, config, windows.digest, step + 1)
            yield TrainingStep(step=step + 1, loss=loss.item())


def _loss(
    policy: Policy, windows: Windows, words: Tensor, chance: torch.Generator, config: TrainingConfig
) -> Tensor:
    """Of random windows, noises, levels of noise and delays."""
    device, shape = chance.device, (config.batch, config.noises)
    which = torch.randint(len(windows), (config.batch,), generator=chance, device=device)
    most = config.policy.max_delay + 1
    delay = torch.randint(most, (config.batch,), generator=chance, device=device)
    batch = windows.batch(which, delay)
    level = LEAST_LEVEL + (1.0 - LEAST_LEVEL) * torch.rand(shape, generator=chance, device=device)
    noise = torch.randn(*shape, *batch.chunk.shape[1:], generator=chance, device=device)
    seen = batch._replace(history=noised(batch.history, chance))
    with torch.autocast(device.type, torch.bfloat16, enabled=config.bfloat16):
        return policy.loss(seen, words[batch.text], level, noise)


def _share(step: int, config: TrainingConfig) -> float:
    """Of the highest learning rate."""
    rising = min(1.0, (step + 1) / config.warm_up)
    return rising * 0.5 * (1.0 + math.cos(math.pi * step / config.steps))


def _save(
    path: Path,
    parts: dict,
    chance: torch.Generator,
    config: TrainingConfig,
    digest: str,
    step: int,
) -> None:
    state = {name: part.state_dict() for name, part in parts.items()}
    state |= {"chance": chance.get_state(), "config": asdict(config), "digest": digest}
    state["step"] = step
    partial = path.with_suffix(".partial")
    torch.save(state, partial)
    partial.replace(path)


def _resume(
    path: Path, parts: dict, chance: torch.Generator, config: TrainingConfig, digest: str
) -> int:
    """Load what `_save` left, if it did; returns the steps done."""
    if not path.exists():
        return 0
    state = torch.load(path, map_location="cpu", weights_only=True)
    if state["config"] != asdict(config):
        raise ValueError(f"{path} is of another configuration: choose another folder or remove it")
    if state["digest"] != digest:
        raise ValueError(f"{path} is of other demonstrations: choose another folder or remove it")
    for name, part in parts.items():
        part.load_state_dict(state[name])
    chance.set_state(state["chance"])
    return state["step"]
