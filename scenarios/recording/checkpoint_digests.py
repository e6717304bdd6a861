"""Which checkpoints an episode's policies and perception were made from, to the bit."""

from hashlib import sha256
from importlib import import_module
from pathlib import Path

from scenarios.catalogue import LEARNED_CONTROLLERS, LEARNED_PLANNERS, PERCEIVING
from scenarios.loop.episode_config import EpisodeConfig


def checkpoint_digests(config: EpisodeConfig) -> dict[str, str]:
    """Return the SHA-256 of each checkpoint used, by `controller`, `planner` and `perception`.

    Raises:
        OSError: a checkpoint cannot be read.
    """
    files = {
        "controller": config.checkpoint,
        "planner": config.planner_checkpoint,
        "perception": config.perception_checkpoint,
    }
    if config.controller in LEARNED_CONTROLLERS:
        shipped = import_module(LEARNED_CONTROLLERS[config.controller]).SHIPPED
        files["controller"] = config.checkpoint or str(shipped)
    if config.planner in LEARNED_PLANNERS:
        from planner.learned.checkpoint import SHIPPED as PLANNER

        files["planner"] = config.planner_checkpoint or str(PLANNER)
    if config.sense in PERCEIVING:
        from controller.perception.checkpoint import SHIPPED as PERCEPTION

        files["perception"] = config.perception_checkpoint or str(PERCEPTION)
    return {role: sha256(Path(f).read_bytes()).hexdigest() for role, f in files.items() if f}
