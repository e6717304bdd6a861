"""A learner in a file: weights and normalisation, with all that says whether it fits."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file, save
from torch import Tensor, nn


class CheckpointError(ValueError):
    """A file is no checkpoint, or one for something else; says which in one line."""


def chosen(path: str | Path | None, shipped: Path, learner: str) -> Path:
    """The checkpoint to take; left out, it is the one that comes with Calot.

    Raises:
        CheckpointError: it is left out, and none comes with Calot.
    """
    if path is None and not shipped.exists():
        raise CheckpointError(f"none comes with Calot: `calot train {learner}` makes one to name")
    return Path(path or shipped)


def write(path: Path, model: nn.Module, config: Any, fits: Mapping[str, Any]) -> None:
    """Write a model, whole or not at all; its weights to three digits, which halves the file.

    Args:
        path: of the file.
        model: its weights and buffers.
        config: a dataclass, what the model is made of.
        fits: what must be the same where it is read.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial")
    said = {"config": json.dumps(asdict(config)), "fits": json.dumps(dict(fits))}
    partial.write_bytes(save(_kept(model), said))
    partial.replace(path)


def _kept(model: nn.Module) -> dict[str, Tensor]:
    """Weights in half precision, whose finer bits are noise; buffers, of metres, as they are."""
    weights = {name: weight.half() for name, weight in model.named_parameters()}
    return model.state_dict() | weights


def read_config(path: Path, fits: Mapping[str, Any], learner: str) -> dict[str, Any]:
    """What a file's model is made of, its weights left unread.

    Raises:
        CheckpointError: it is not one of a `learner` that fits.
    """
    try:
        with safe_open(path, "pt") as file:
            said = file.metadata() or {}
        found, config = json.loads(said["fits"]), json.loads(said["config"])
    except OSError as error:
        raise CheckpointError(f"{path} cannot be read: {_one_line(error)}") from None
    except (SafetensorError, KeyError, ValueError):
        raise CheckpointError(f"{path} is no checkpoint of a {learner}") from None
    for name, wanted in fits.items():
        if found.get(name) != wanted:
            raise CheckpointError(f"{path}: {name} {found.get(name)}, but here it is {wanted}")
    return config


def read_weights(path: Path, model: nn.Module) -> None:
    """Give a model the weights of a file.

    Raises:
        CheckpointError: they are damaged.
    """
    try:
        model.load_state_dict(load_file(path))
    except (SafetensorError, RuntimeError) as error:
        raise CheckpointError(f"{path}: its weights are damaged: {_one_line(error)}") from None


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
