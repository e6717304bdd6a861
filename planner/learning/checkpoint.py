"""Read and write checkpoints: weights and normalisation in a file, with their requirements."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any, Generic, TypeVar

import msgspec
import numpy as np
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file, save
from torch import Tensor, nn

from planner.learning.files import content_hash, from_json, write_atomic

HASH = "sha256"  # in the file's metadata
Config = TypeVar("Config")
Model = TypeVar("Model", bound=nn.Module)


class CheckpointError(ValueError):
    """A file is not a checkpoint, or does not fit; the message gives the reason in one line."""


@dataclass(frozen=True, kw_only=True)
class Checkpoints(Generic[Config, Model]):
    """Reads and writes the checkpoints of one learner.

    Attributes:
        learner: The learner's name in `calot train`.
        holds: Description of a file's content.
        shipped: Path of the checkpoint that comes with Calot, if there is one.
        fits: Values that must be the same when a checkpoint is written and when it is read. Their
            names distinguish the file from another learner's file.
        config_type: The class of a configuration; its annotations bound the fields.
        model_from: Returns a model of a configuration, with any weights.
        config_of: Returns the configuration of a model.
    """

    learner: str
    holds: str
    shipped: Path
    fits: Mapping[str, Any]
    config_type: type[Config]
    model_from: Callable[[Config], Model]
    config_of: Callable[[Model], Config] = attrgetter("config")

    def chosen(self, path: str | Path | None) -> Path:
        """Return the path of the checkpoint to use: the given one, or the one that is shipped.

        Raises:
            CheckpointError: No path is given, and no checkpoint is shipped.
        """
        if path is None and not self.shipped.exists():
            how = f"`calot train {self.learner}` makes one to name"
            which = f"none of world version {self.fits.get('world version')}"
            raise CheckpointError(f"{which} comes with Calot: {how}")
        return Path(path or self.shipped)

    def save(self, path: Path, model: Model) -> None:
        """Write a model atomically, with weights in half precision, which halves the file."""
        config = json.dumps(asdict(self.config_of(model)))  # pyright: ignore[reportArgumentType]
        said, weights = {"config": config, "fits": json.dumps(dict(self.fits))}, _kept(model)
        write_atomic(path, save(weights, said | {HASH: _hash(said, weights)}))

    def load(self, path: str | Path | None = None) -> Model:
        """Return the model of a file, by default of the shipped one, ready for inference.

        Raises:
            CheckpointError: There is no file, or its model does not fit or is damaged.
        """
        path = self.chosen(path)
        try:
            with safe_open(path, "pt") as file:
                said = file.metadata() or {}
            model, weights = self.model_from(self._config(path, said)), load_file(path)
            _require_whole(said, weights)
            model.load_state_dict(weights)
        except OSError as error:
            raise CheckpointError(f"{path} cannot be read: {_why(path, error)}") from None
        except SafetensorError:
            raise CheckpointError(self._another(path)) from None
        except (_DamagedError, RuntimeError) as error:
            why = f"its weights are damaged: {_one_line(error):.200}"
            raise CheckpointError(f"{path}: {why}") from None
        return model.eval().requires_grad_(False)

    def config(self, path: str | Path | None = None) -> Config:
        """Return the configuration of a file's model, after the checks of `load`.

        Raises:
            CheckpointError: As in `load`.
        """
        return self.config_of(self.load(path))

    def _another(self, path: Path) -> str:
        return f"{path} is no checkpoint of a {self.holds}"

    def _config(self, path: Path, said: Mapping[str, str]) -> Config:
        """Return the configuration in a file's metadata, if it fits."""
        try:
            found, told = (dict(from_json(said[name])) for name in ("fits", "config"))
        except (KeyError, TypeError, ValueError):
            raise CheckpointError(self._another(path)) from None
        if found.keys() != self.fits.keys():
            raise CheckpointError(self._another(path))
        for name, wanted in self.fits.items():
            if found[name] != wanted:
                here = f"{name} {found[name]!r:.40}, but here it is {wanted}"
                raise CheckpointError(f"{path}: {here}")
        try:
            config = msgspec.convert(told, self.config_type)
            kept = from_json(msgspec.json.encode(config))
            if unlike := [name for name in told if kept.get(name) != told[name]]:
                raise ValueError(f"unknown: {', '.join(unlike)}")
            return config
        except ValueError as error:
            why = f"its configuration is of another version: {_one_line(error)}"
            raise CheckpointError(f"{path}: {why}") from None


class _DamagedError(ValueError):
    """The weights are not finite, or differ from the saved weights."""


def _require_whole(said: Mapping[str, str], weights: Mapping[str, Tensor]) -> None:
    """Check that weights are finite, and match the saved hash, which older files lack."""
    for name, weight in weights.items():
        if not torch.isfinite(weight).all():
            raise _DamagedError(f"{name} is not finite everywhere")
    own = {name: text for name, text in said.items() if name != HASH}
    if said.get(HASH, saved := _hash(own, weights)) != saved:
        raise _DamagedError("the file was changed after it was saved")


def _hash(said: Mapping[str, str], weights: Mapping[str, Tensor]) -> str:
    texts = {f"said {name}": np.array(text) for name, text in said.items()}
    return content_hash(texts | {name: weight.numpy() for name, weight in weights.items()})


def _kept(model: nn.Module) -> dict[str, Tensor]:
    """Return weights in half precision (finer bits are noise), and buffers unchanged (metres)."""
    weights = {name: weight.detach().half() for name, weight in model.named_parameters()}
    return {name: weight.cpu() for name, weight in (model.state_dict() | weights).items()}


def _why(path: str | Path, error: OSError) -> str:
    if os.path.isdir(path):
        return "it is a folder"
    return _one_line(error) if os.path.exists(path) else "there is no such file"


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
