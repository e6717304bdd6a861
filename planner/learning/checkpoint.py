"""Checkpoints: weights and normalisation in a file, with what they require of their user."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any, Generic, TypeVar

from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file, save
from torch import Tensor, nn

from planner.learning.atomic_write import write_atomic

Config = TypeVar("Config")
Model = TypeVar("Model", bound=nn.Module)


class CheckpointError(ValueError):
    """A file is not a checkpoint, or does not fit; the message says which in one line."""


@dataclass(frozen=True, kw_only=True)
class Checkpoints(Generic[Config, Model]):
    """Reads and writes the checkpoints of one learner.

    Attributes:
        learner: as `calot train` names it.
        holds: what is in a file, in words.
        shipped: the one that comes with Calot, if one does.
        fits: what must be the same when a checkpoint is written and when it is read; by its names
            a file is told from another learner's.
        config_from: makes a configuration of what JSON has kept of it.
        model_from: makes a model of a configuration; its weights do not matter.
        config_of: returns the configuration of a model.
    """

    learner: str
    holds: str
    shipped: Path
    fits: Mapping[str, Any]
    config_from: Callable[[dict[str, Any]], Config]
    model_from: Callable[[Config], Model]
    config_of: Callable[[Model], Config] = attrgetter("config")

    def chosen(self, path: str | Path | None) -> Path:
        """Return the path of the checkpoint to use: the given one, or the one that is shipped.

        Raises:
            CheckpointError: no path is given, and no checkpoint is shipped.
        """
        if path is None and not self.shipped.exists():
            how = f"`calot train {self.learner}` makes one to name"
            raise CheckpointError(f"none comes with Calot: {how}")
        return Path(path or self.shipped)

    def save(self, path: Path, model: Model) -> None:
        """Write a model atomically; its weights in half precision, which halves the file."""
        config = json.dumps(asdict(self.config_of(model)))  # pyright: ignore[reportArgumentType]
        said = {"config": config, "fits": json.dumps(dict(self.fits))}
        write_atomic(path, save(_kept(model), said))

    def load(self, path: str | Path | None = None) -> Model:
        """Return the model of a file, by default of the one shipped, ready for inference.

        Raises:
            CheckpointError: there is no file, or it has no model that fits, or a damaged one.
        """
        path = self.chosen(path)
        model = self.model_from(self.config(path))
        try:
            model.load_state_dict(load_file(path))
        except (SafetensorError, RuntimeError) as error:
            raise CheckpointError(f"{path}: its weights are damaged: {_one_line(error)}") from None
        return model.eval().requires_grad_(False)

    def config(self, path: str | Path | None = None) -> Config:
        """Return the configuration of a file's model, as `load` does, without reading its weights.

        Raises:
            CheckpointError: there is no file, or it has no model that fits.
        """
        path = self.chosen(path)
        another = f"{path} is no checkpoint of a {self.holds}"
        try:
            with safe_open(path, "pt") as file:
                said = file.metadata() or {}
            found, config = (dict(json.loads(said[name])) for name in ("fits", "config"))
        except OSError as error:
            raise CheckpointError(f"{path} cannot be read: {_why(path, error)}") from None
        except (SafetensorError, KeyError, TypeError, ValueError):
            raise CheckpointError(another) from None
        if found.keys() != self.fits.keys():
            raise CheckpointError(another)
        for name, wanted in self.fits.items():
            if found.get(name) != wanted:
                raise CheckpointError(f"{path}: {name} {found.get(name)}, but here it is {wanted}")
        try:
            return self.config_from(config)
        except (KeyError, TypeError, ValueError) as error:
            why = f"its configuration is of another version: {_one_line(error)}"
            raise CheckpointError(f"{path}: {why}") from None


def _kept(model: nn.Module) -> dict[str, Tensor]:
    """Return weights in half precision (finer bits are noise), and buffers unchanged (metres)."""
    weights = {name: weight.half() for name, weight in model.named_parameters()}
    return model.state_dict() | weights


def _why(path: str | Path, error: OSError) -> str:
    if os.path.isdir(path):
        return "it is a folder"
    return _one_line(error) if os.path.exists(path) else "there is no such file"


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
