"""Run the training loop of every network: gradient descent that resumes exactly."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from hashlib import sha256
from operator import attrgetter
from pathlib import Path
from pickle import UnpicklingError
from typing import Any, ClassVar, Protocol, TypeVar, cast

import torch
from torch import Tensor, nn

from planner.learning.checkpoint import Checkpoints
from planner.learning.files import write_atomic

STATE_FILE, LOG_FOLDER = "training.pt", "tensorboard"
GRADIENT_MAX = 1.0
FINE_TUNING_SHARE = 0.3  # of the learning rate
DIFFERENT = (  # a state's training differs from the present one
    ("config", "is of another configuration"),
    ("digest", "is of other demonstrations"),
    ("device", "was trained on another device"),
)
Model = TypeVar("Model", bound=nn.Module)
Learning = TypeVar("Learning", bound=nn.Module, contravariant=True)
Given = TypeVar("Given")
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
        shape: Name of the setting that holds the model's configuration.
        shape_of: Path of that configuration from the model.
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
    shape: ClassVar[str] = "policy"
    shape_of: ClassVar[str] = "config"


def fine_tuning(
    checkpoints: Checkpoints[Any, Model], config: ScheduleT, base: Path
) -> tuple[ScheduleT, Model]:
    """Return the settings for fine-tuning a checkpoint, with a lower rate, and its model.

    Raises:
        CheckpointError: As in `Checkpoints.load`.
    """
    model = checkpoints.load(base)
    rate = FINE_TUNING_SHARE * config.learning_rate
    digest = sha256(base.read_bytes()).hexdigest()
    shape = {config.shape: attrgetter(config.shape_of)(model)}
    return replace(config, learning_rate=rate, base=digest, **shape), model


class TrainingData(Protocol[Learning]):
    """What a model is trained on, on one device.

    Attributes:
        digest: Digest of all data, in hex.
    """

    digest: str

    def normalise(self, model: Learning, chance: torch.Generator, /) -> None:
        """Set the normalisation of a model that begins with random weights."""
        ...

    def loss(self, model: Learning, chance: torch.Generator, /) -> Tensor:
        """Draw a batch and return its loss."""
        ...


@dataclass(frozen=True, kw_only=True)
class TrainingStep:
    """The number of finished steps, and the loss of the last batch."""

    step: int
    loss: float


def learn(
    data_of: Callable[[Given, ScheduleT, str], TrainingData[Model]],
    checkpoints: Checkpoints[Any, Model],
    given: Given,
    config: ScheduleT,
    out: Path,
    device: str = "cpu",
    base: Model | None = None,
) -> Iterator[TrainingStep]:
    """Train a model on what is given, or resume the training in `out`; see `optimise`.

    Raises:
        ValueError: There is nothing to learn from, or as in `optimise`. Nothing is changed.
    """
    make = partial(checkpoints.model_from, getattr(config, config.shape))
    data, weights = data_of(given, config, device), out / checkpoints.shipped.name
    return optimise(make, data, config, weights, checkpoints.save, device, base)


def optimise(
    make: Callable[[], Model],
    data: TrainingData[Model],
    config: Schedule,
    weights: Path,
    save: Callable[[Path, Model], None],
    device: str = "cpu",
    base: nn.Module | None = None,
) -> Iterator[TrainingStep]:
    """Train a model, or resume the training in the folder of `weights`.

    The folder holds TensorBoard's curves and the state to resume from, too.

    Args:
        make: Returns a model with random weights.
        data: The data.
        config: The schedule, and all settings that must be the same to resume.
        weights: File of the averaged model, written together with the state to resume from. A
            finished training writes the file anew if it was moved away.
        save: Writes the averaged model.
        device: Where to train.
        base: The model to start from, which keeps its normalisation; None for random weights.

    Raises:
        ValueError: The folder holds the training of another configuration, on other data or on
            another device, or a file that is no state of a training. Nothing is changed.
    """
    from torch.utils.tensorboard.writer import SummaryWriter

    torch.manual_seed(config.seed)
    chance = torch.Generator(device).manual_seed(config.seed)
    model = make().to(device)
    if base is None:
        data.normalise(model, chance)
    else:
        model.load_state_dict(base.state_dict())
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
    said = {"config": asdict(config), "digest": data.digest, "device": str(chance.device)}
    path = weights.with_name(STATE_FILE)
    begin = _resume(path, parts, chance, said)
    if begin == config.steps and not weights.exists():
        save(weights, cast(Model, average.module))
    with SummaryWriter(weights.with_name(LOG_FOLDER), purge_step=begin) as log:
        for step in range(begin, config.steps):
            rate = config.learning_rate * _share(step, config)
            for group in optimiser.param_groups:
                group["lr"] = rate
            loss = data.loss(model, chance)
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(model.parameters(), GRADIENT_MAX)
            optimiser.step()
            average.update_parameters(model)
            log.add_scalar("loss", loss.item(), step)
            log.add_scalar("learning rate", rate, step)
            if (step + 1) % config.save_every == 0 or step + 1 == config.steps:
                save(weights, cast(Model, average.module))
                _save(path, parts, chance, said, step + 1)
            yield TrainingStep(step=step + 1, loss=loss.item())


def _share(step: int, config: Schedule) -> float:
    """Return the share of the highest learning rate at a step."""
    rising = min(1.0, (step + 1) / config.warm_up)
    return rising * 0.5 * (1.0 + math.cos(math.pi * step / config.steps))


def _save(path: Path, parts: dict, chance: torch.Generator, said: dict, step: int) -> None:
    state = {name: part.state_dict() for name, part in parts.items()}
    content = io.BytesIO()
    torch.save(state | said | {"chance": chance.get_state(), "step": step}, content)
    write_atomic(path, content.getvalue())


def _resume(path: Path, parts: dict, chance: torch.Generator, said: dict) -> int:
    """Load the state that `_save` wrote, if there is one; return the steps done."""
    if not path.exists():
        return 0
    try:
        state = torch.load(path, map_location="cpu", weights_only=True)
        difference = next((why for name, why in DIFFERENT if state[name] != said[name]), "")
        if not difference:
            for name, part in parts.items():
                part.load_state_dict(state[name])
            chance.set_state(state["chance"])
            return state["step"]
    except (EOFError, IndexError, KeyError, RuntimeError, TypeError, UnpicklingError) as error:
        difference = f"cannot be continued ({type(error).__name__})"
    raise ValueError(f"{path} {difference}: choose another folder or remove it")
