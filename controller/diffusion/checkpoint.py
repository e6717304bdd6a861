"""A policy in a file: weights and normalisation, with all that says whether it fits."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file, save

from controller.action import ACTION_SIZE
from controller.diffusion.config import PolicyConfig
from controller.diffusion.policy import Policy
from tissue_sim.observation import VECTOR_SIZE
from tissue_sim.world import WORLD_VERSION

SHIPPED = Path(__file__).with_name("policy.safetensors")
FITS = {
    "schema": 1,
    "world version": WORLD_VERSION,
    "observation size": VECTOR_SIZE,
    "action size": ACTION_SIZE,
}
"""What a checkpoint must have been made with."""


class CheckpointError(ValueError):
    """A file is no checkpoint, or one for something else; says which in one line."""


def chosen(path: str | Path | None) -> Path:
    """The checkpoint to take; left out, it is the one that comes with Calot.

    Raises:
        CheckpointError: it is left out, and none comes with Calot.
    """
    if path is None and not SHIPPED.exists():
        raise CheckpointError("none comes with Calot: `calot train controller` makes one to name")
    return Path(path or SHIPPED)


def save_checkpoint(path: Path, policy: Policy) -> None:
    """Write the policy, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial")
    said = {"config": json.dumps(asdict(policy.config)), "fits": json.dumps(FITS)}
    partial.write_bytes(save(policy.state_dict(), said))
    partial.replace(path)


def load_checkpoint(path: Path) -> Policy:
    """The policy of a file, ready to sample.

    Raises:
        CheckpointError: there is none that fits this world, its observations and actions.
    """
    policy = Policy(checked_config(path))
    try:
        policy.load_state_dict(load_file(path))
    except (SafetensorError, RuntimeError) as error:
        raise CheckpointError(f"{path}: its weights are damaged: {_one_line(error)}") from None
    return policy.eval().requires_grad_(False)


def checked_config(path: Path) -> PolicyConfig:
    """The configuration that a file was trained with, its weights left unread.

    Raises:
        CheckpointError: as of `load_checkpoint`.
    """
    try:
        with safe_open(path, "pt") as file:
            said = file.metadata() or {}
        fits, config = json.loads(said["fits"]), json.loads(said["config"])
    except OSError as error:
        raise CheckpointError(f"{path} cannot be read: {_one_line(error)}") from None
    except (SafetensorError, KeyError, ValueError):
        raise CheckpointError(f"{path} is no checkpoint of a diffusion policy") from None
    for name, wanted in FITS.items():
        if fits.get(name) != wanted:
            raise CheckpointError(f"{path}: {name} {fits.get(name)}, but here it is {wanted}")
    return PolicyConfig(**config | {"history": tuple(config["history"])})


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
