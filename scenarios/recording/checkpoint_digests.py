"""Identify the checkpoints of an episode's policies and perception, to the bit."""

from hashlib import sha256
from importlib import import_module
from pathlib import Path

from scenarios.catalogue import SENSES, policy_named
from scenarios.loop.episode_config import EpisodeConfig


def checkpoint_digests(config: EpisodeConfig) -> dict[str, str]:
    """Return the SHA-256 of each checkpoint used, by `controller`, `planner` and `perception`.

    Raises:
        CheckpointError: No checkpoint is named, and none is shipped.
        OSError: A checkpoint cannot be read.
    """
    files: dict[str, str | Path | None] = {
        "controller": config.checkpoint,
        "planner": config.planner_checkpoint,
        "perception": config.perception_checkpoint,
    }
    modules = {
        "controller": policy_named(config.controller).checkpoint,
        "planner": policy_named(config.planner).checkpoint,
        "perception": SENSES[config.sense].checkpoint if config.sense in SENSES else None,
    }
    for role, module in modules.items():
        if module is not None:
            files[role] = import_module(module).CHECKPOINTS.chosen(files[role])
    return {role: sha256(Path(f).read_bytes()).hexdigest() for role, f in files.items() if f}
