"""Run the training loop of every network: gradient descent that resumes exactly."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
from pathlib import Path
from pickle import UnpicklingError
from typing import TypeVar, cast

import torch
from torch import Tensor, nn

from planner.learning.files import write_atomic

STATE_FILE, LOG_FOLDER = "training.pt", "tensorboard"
GRADIENT_MAX = 1.0
FINE_TUNING_SHARE = 0.3  # of the learning rate
Model = TypeVar("Model", bound=nn.Module)
ScheduleT = TypeVar("ScheduleT", bound="Schedule")


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """The settings of a training.

    Attributes:
        steps: Number of steps of the optimiser.
        batch: Number of samples in a step.
        learning_rate: Highest rate; it rises over `warm_up` steps and falls to zero as a cosine.
        average: Decay of the weights' moving average; the average is saved.
        save_every: Number of steps from one saved state to the next.
        bfloat16: Whether to multiply matrices in bfloat16, which is faster on some processors.
        base: Digest of the checkpoint that is fine-tuned; "" to start from random weights.
    """

    steps: int
    batch: int = 512
    learning_rate: float = 1e-3
    weight_decay: float = 1e-4
    warm_up: int = 300
    average: float = 0.999
    save_every: int = 1000
    seed: int = 0
    bfloat16: bool = False
    base: str = ""


def fine_tuning_schedule(base: Path, schedule: ScheduleT) -> ScheduleT:
    """Return the schedule for fine-tuning `base`, with a lower learning rate."""
    return replace(
        schedule,
        learning_rate=FINE_TUNING_SHARE * schedule.learning_rate,
        base=sha256(base.read_bytes()).hexdigest(),
    )


@dataclass(frozen=True, kw_only=True)
class TrainingStep:
    """The number of finished steps, and the loss of the last batch."""

    step: int
    loss: float


def optimise(
    model: Model,
    loss_of_batch: Callable[[Model], Tensor],
    chance: torch.Generator,
    config: Schedule,
    out: Path,
    digest: str,
    weights: Path,
    save: Callable[[Path, Model], None],
) -> Iterator[TrainingStep]:
    """Train a model, or resume the training that `out` holds.

    Args:
        model: The model with its initial weights.
        loss_of_batch: Draws a batch and returns its loss.
        chance: The source of all randomness.
        config: The schedule, and all settings that must be the same to resume.
        out: Folder for TensorBoard's curves and the state to resume from.
        digest: Digest of the training data.
        weights: File of the averaged model, written together with the state to resume from. A
            finished training writes the file anew if it was moved away.
        save: Writes the averaged model.

    Raises:
        ValueError: `out` holds the training of another configuration, on other data or on another
            device, or a file that is no state of a training. Nothing is changed.
    """
    from torch.utils.tensorboard.writer import SummaryWriter

    average = torch.optim.swa_utils.AveragedModel(
        model, multi_avg_fn=torch.optim.swa_utils.get_ema_multi_avg_fn(config.average)
    )
    optimiser = torch.optim.AdamW(
        model.parameters(),
        lr=config.learning_rate,
        weight_decay=config.weight_decay,
        fused=True,  # unfused, denormal moments make it slow on a CPU
    )
    parts = {"model": model, "average": average, "optimiser": optimiser}
    begin = _resume(out / STATE_FILE, parts, chance, config, digest)
    if begin == config.steps and not weights.exists():
        save(weights, cast(Model, average.module))
    with SummaryWriter(out / LOG_FOLDER, purge_step=begin) as log:
        for step in range(begin, config.steps):
            rate = config.learning_rate * _share(step, config)
            for group in optimiser.param_groups:
                group["lr"] = rate
            loss = loss_of_batch(model)
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(model.parameters(), GRADIENT_MAX)
            optimiser.step()
            average.update_parameters(model)
            log.add_scalar("loss", loss.item(), step)
            log.add_scalar("learning rate", rate, step)
            if (step + 1) % config.save_every == 0 or step + 1 == config.steps:
                save(weights, cast(Model, average.module))
                _save(out / STATE_FILE, parts, chance, config, digest, step + 1)
            yield TrainingStep(step=step + 1, loss=loss.item())


def _share(step: int, config: Schedule) -> float:
    """Return the share of the highest learning rate at a step."""
    rising = min(1.0, (step + 1) / config.warm_up)
    return rising * 0.5 * (1.0 + math.cos(math.pi * step / config.steps))


def _save(
    path: Path, parts: dict, chance: torch.Generator, config: Schedule, digest: str, step: int
) -> None:
    state = {name: part.state_dict() for name, part in parts.items()}
    state |= {"chance": chance.get_state(), "config": asdict(config), "digest": digest}
    state |= {"device": str(chance.device), "step": step}
    content = io.BytesIO()
    torch.save(state, content)
    write_atomic(path, content.getvalue())


def _resume(path: Path, parts: dict, chance: torch.Generator, config: Schedule, digest: str) -> int:
    """Load the state that `_save` wrote, if there is one; return the steps done."""
    if not path.exists():
        return 0
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
        difference = _difference(state, chance, config, digest)
        if not difference:
            for name, part in parts.items():
                part.load_state_dict(state[name])
            chance.set_state(state["chance"])
            return state["step"]
    except (EOFError, IndexError, KeyError, RuntimeError, TypeError, UnpicklingError) as error:
        difference = f"cannot be continued ({type(error).__name__})"
    raise ValueError(f"{path} {difference}: choose another folder or remove it")


def _difference(state: dict, chance: torch.Generator, config: Schedule, digest: str) -> str:
    """Return in words how a state's training differs from this training; "" if it does not."""
    if state["config"] != asdict(config):
        return "is of another configuration"
    if state["digest"] != digest:
        return "is of other demonstrations"
    return "" if state["device"] == str(chance.device) else "was trained on another device"
