"""Run one episode, and keep its recording even if the episode breaks off."""

from __future__ import annotations

import os
import time
import traceback
from asyncio import CancelledError
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from planner.learning.files import write_atomic
from scenarios.files.errors import WorkerDiedError, describe_error
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.observer import Observer
from scenarios.loop.results import EpisodeResult
from scenarios.recording.recorder import Recorder
from scenarios.workers.process import importing

if TYPE_CHECKING:
    from scenarios.loop.person.inbox import Inbox

BREAKS_OFF = (Exception, SystemExit, CancelledError)
"""The exceptions of a policy or a library that end their episode, and nothing else."""


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """An attempted episode.

    Attributes:
        unwritable: The reason why its recording could not be saved; None if it was saved.
    """

    result: EpisodeResult
    unwritable: str | None = None


def attempt_episode(
    config: EpisodeConfig,
    out: Path,
    observers: Sequence[Observer] = (),
    inbox: Inbox | None = None,
    name: str | None = None,
) -> Attempt:
    """Run one episode; an exception in it becomes the result's error, not a failure.

    An exit that a policy requests of Python counts as an exception; Ctrl-C is raised.

    `inbox` holds people's words to the episode; `name` is that of its files, by default its seed.

    The call leaves `out`/episodes/NAME.npz and, after an exception, its traceback in
    `out`/errors/NAME.txt, as far as the disk has room. An earlier traceback is removed.
    """
    name = name or str(config.seed)
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # small tensors: more threads are slower
    with importing():
        from scenarios.run_episode import run_episode

    start_s, trace = time.perf_counter(), trace_path(out, name)
    recorder = Recorder(config=config, path=out / "episodes" / f"{name}.npz")
    try:
        trace.unlink(missing_ok=True)
        with recorder:
            result = run_episode(config, [recorder, *observers], inbox)
    except BREAKS_OFF as error:
        with suppress(OSError):  # the result reports the error without its traceback
            write_atomic(trace, traceback.format_exc().encode())
        result = broken_off(config, error, wall_s=time.perf_counter() - start_s)
    unwritable = None if recorder.is_saved else f"{recorder.path}: {result.error}"
    return Attempt(result=result, unwritable=unwritable)


def trace_path(out: Path, name: str) -> Path:
    """Return the path of the traceback of an interrupted episode."""
    return out / "errors" / f"{name}.txt"


def lost(config: EpisodeConfig, death: WorkerDiedError) -> Attempt:
    """Return the attempt of an episode that ended by the death of its process."""
    return Attempt(result=broken_off(config, death))


def broken_off(config: EpisodeConfig, error: BaseException, wall_s: float = 0.0) -> EpisodeResult:
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
