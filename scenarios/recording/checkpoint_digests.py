"""Which checkpoints an episode's policies and perception were made from, to the bit."""

from hashlib import sha256
from importlib import import_module
from pathlib import Path

from scenarios.catalogue import LEARNED_CONTROLLERS, LEARNED_PLANNERS, PERCEIVING
from scenarios.loop.episode_config import EpisodeConfig


def checkpoint_digests(config: EpisodeConfig) -> dict[str, str]:
    """Return the SHA-256 of each checkpoint used, by `controller`, `planner` and `perception`.

    Raises:
        CheckpointError: no checkpoint is named, and none is shipped.
        OSError: a checkpoint cannot be read.
    """
    files: dict[str, str | Path | None] = {
        "controller": config.checkpoint,
        "planner": config.planner_checkpoint,
        "perception": config.perception_checkpoint,
    }
    if config.controller in LEARNED_CONTROLLERS:
        checkpoints = import_module(LEARNED_CONTROLLERS[config.controller]).CHECKPOINTS
        files["controller"] = checkpoints.chosen(config.checkpoint)
    if config.planner in LEARNED_PLANNERS:
        from planner.learned.checkpoint import CHECKPOINTS as PLANNERS

        files["planner"] = PLANNERS.chosen(config.planner_checkpoint)
    if config.sense in PERCEIVING:
        from controller.perception.checkpoint import CHECKPOINTS as PERCEPTIONS

        files["perception"] = PERCEPTIONS.chosen(config.perception_checkpoint)
    return {role: sha256(Path(f).read_bytes()).hexdigest() for role, f in files.items() if f}
