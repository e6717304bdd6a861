"""Checkpoints: weights and normalisation in a file, with what they require of their user."""

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
    """A file is not a checkpoint, or does not fit; the message says which in one line."""


def chosen(path: str | Path | None, shipped: Path, learner: str) -> Path:
    """Return the path of the checkpoint to use: the given one, or the one shipped with Calot.

    Raises:
        CheckpointError: no path is given, and no checkpoint is shipped.
    """
    if path is None and not shipped.exists():
        raise CheckpointError(f"none comes with Calot: `calot train {learner}` makes one to name")
    return Path(path or shipped)


def write(path: Path, model: nn.Module, config: Any, fits: Mapping[str, Any]) -> None:
    """Write a model atomically; its weights in half precision, which halves the file.

    Args:
        path: of the file.
        model: its weights and buffers.
        config: a dataclass that describes the model.
        fits: what must be the same when the file is read.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial")
    said = {"config": json.dumps(asdict(config)), "fits": json.dumps(dict(fits))}
    partial.write_bytes(save(_kept(model), said))
    partial.replace(path)


def _kept(model: nn.Module) -> dict[str, Tensor]:
    """Return weights in half precision (finer bits are noise), and buffers unchanged (metres)."""
    weights = {name: weight.half() for name, weight in model.named_parameters()}
    return model.state_dict() | weights


def read_config(path: Path, fits: Mapping[str, Any], learner: str) -> dict[str, Any]:
    """Return the configuration of a file's model, without reading its weights.

    Raises:
        CheckpointError: the file is not a checkpoint of a `learner` that fits.
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
    """Load the weights of a file into a model.

    Raises:
        CheckpointError: the weights are damaged.
    """
    try:
        model.load_state_dict(load_file(path))
    except (SafetensorError, RuntimeError) as error:
        raise CheckpointError(f"{path}: its weights are damaged: {_one_line(error)}") from None


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
