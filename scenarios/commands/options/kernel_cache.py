"""Check before any work that the world's kernels are compiled, or can be."""

import os
from pathlib import Path

from scenarios.commands.options.output_path import require_writable_folder
from scenarios.files.errors import BadInputError
from tissue_sim.cached_files import cache_root

ROOM_BYTES = 4_000_000  # the kernels and what the renderer reads take half of it


def require_kernel_cache() -> None:
    """Check that the caches can be written to, or hold all that a world needs.

    Raises:
        BadInputError: neither; names the folder, and the variable that names another one.
    """
    folders = [("XDG_CACHE_HOME", cache_root() / "calot")]
    if kernels := os.environ.get("WARP_CACHE_PATH"):
        folders.append(("WARP_CACHE_PATH", Path(kernels)))
    try:
        for variable, folder in folders:
            require_writable_folder(folder, variable, ROOM_BYTES)
    except BadInputError:
        if not _a_world_begins():
            raise


def _a_world_begins() -> bool:
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # as for every episode
    from scenarios.loop.episode_config import EpisodeConfig
    from scenarios.run_episode import begin

    try:
        episode = begin(EpisodeConfig(planner="rule", controller="idle"))
        next(iter(episode.steps()))
    except Exception:  # Warp raises it where it cannot compile
        return False
    return True
