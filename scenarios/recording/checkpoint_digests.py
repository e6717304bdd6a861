"""Which files the learned planner and controller of an episode are, to the bit."""

from hashlib import sha256
from pathlib import Path

from scenarios.catalogue import LEARNED_CONTROLLERS, LEARNED_PLANNERS
from scenarios.loop.episode_config import EpisodeConfig


def checkpoint_digests(config: EpisodeConfig) -> dict[str, str]:
    """Returns the SHA-256 of the checkpoint of each that is learned, by `controller` and `planner`.

    Raises:
        OSError: One cannot be read.
    """
    files: dict[str, str | Path] = {}
    if config.controller in LEARNED_CONTROLLERS:
        from controller.diffusion.checkpoint import SHIPPED as CONTROLLER

        files["controller"] = config.checkpoint or CONTROLLER
    if config.planner in LEARNED_PLANNERS:
        from planner.learned.checkpoint import SHIPPED as PLANNER

        files["planner"] = config.planner_checkpoint or PLANNER
    return {role: sha256(Path(file).read_bytes()).hexdigest() for role, file in files.items()}
