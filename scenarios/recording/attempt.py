"""Run one episode and keep its recording whatever happens."""

from __future__ import annotations

import os
import time
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from scenarios.files.atomic_write import write_atomic
from scenarios.files.errors import describe_error
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.observer import Observer
from scenarios.loop.results import EpisodeResult
from scenarios.recording.recorder import Recorder

if TYPE_CHECKING:
    from scenarios.loop.person.inbox import Inbox


def attempt_episode(
    config: EpisodeConfig,
    out: Path,
    observers: Sequence[Observer] = (),
    inbox: Inbox | None = None,
    name: str | None = None,
) -> EpisodeResult:
    """Run one episode; an exception in it becomes the result's error, not a failure.

    `inbox` holds what people say to it; `name` is that of its files, by default its seed.

    Leaves `out`/episodes/NAME.npz and, after an exception, its traceback in `out`/errors/NAME.txt.
    """
    name = name or str(config.seed)
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # small tensors: more threads are slower
    from scenarios.run_episode import run_episode

    start_s = time.perf_counter()
    try:
        with Recorder(config=config, path=out / "episodes" / f"{name}.npz") as recorder:
            return run_episode(config, [recorder, *observers], inbox)
    except Exception as error:
        write_atomic(out / "errors" / f"{name}.txt", traceback.format_exc().encode())
        return broken_off(config, error, wall_s=time.perf_counter() - start_s)


def broken_off(config: EpisodeConfig, error: Exception, wall_s: float = 0.0) -> EpisodeResult:
    """Return the result of an episode that `error` ended."""
    return EpisodeResult(
        scenario=config.scenario,
        seed=config.seed,
        planner=config.planner,
        controller=config.controller,
        success=False,
        error=describe_error(error),
        wall_s=wall_s,
        sense=config.sense,
    )
