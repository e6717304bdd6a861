"""A pool of workers on the machines of a Ray cluster, of which this machine is a node.

The current folder, and the files that the command names, lie on a disk that all nodes share.
"""

import os
from collections.abc import Callable
from typing import Any, TypeVar

import ray  # pyright: ignore[reportMissingImports]
from ray.exceptions import RayError  # pyright: ignore[reportMissingImports]

from scenarios.files.errors import WorkerDiedError
from scenarios.workers.local_processes import STOP_TIMEOUT_S
from scenarios.workers.pool import Job, WorkerPool

Config = TypeVar("Config")
Result = TypeVar("Result")


class RayWorkers(WorkerPool[Result]):
    """A pool of Ray tasks with one core each; Ray manages their processes."""

    def __init__(self, attempt: Callable[[Any], Result], address: str) -> None:
        """Join the cluster whose head answers at `address`, HOST:PORT."""
        connect(address)
        self._attempt, self._folder = attempt, os.getcwd()
        self._jobs: dict[ray.ObjectRef, Job] = {}

    @property
    def n_busy(self) -> int:
        return len(self._jobs)

    def begin(self, job: Job) -> None:
        """Start a job on any node; Ray must not retry it, so that deaths are counted."""
        task = ray.remote(num_cpus=1, max_retries=0)(_attempted)
        self._jobs[task.remote(self._folder, self._attempt, job.config)] = job

    def wait(self) -> None:
        ray.wait(list(self._jobs), num_returns=1)

    def ended(self) -> list[tuple[Job, Result | WorkerDiedError]]:
        return [(self._jobs.pop(task), _outcome(task)) for task in self._done(within_s=0.0)]

    def leave(self) -> list[Result]:
        for task in self._jobs:
            ray.cancel(task)
        last = [_outcome(task) for task in self._done(within_s=STOP_TIMEOUT_S)]
        self._jobs.clear()
        return [outcome for outcome in last if not isinstance(outcome, WorkerDiedError)]

    def _done(self, within_s: float) -> list[ray.ObjectRef]:
        """Return the tasks that are done within some seconds."""
        tasks = list(self._jobs)
        return ray.wait(tasks, num_returns=len(tasks), timeout=within_s)[0] if tasks else []


def connect(address: str) -> None:
    """Join the cluster, unless this process has already joined.

    Raises:
        ConnectionError, RuntimeError, ValueError: The cluster cannot be joined.
    """
    if not ray.is_initialized():
        ray.init(address=address, logging_level="ERROR", log_to_driver=False)


def _attempted(folder: str, attempt: Callable[[Config], Result], config: Config) -> Result:
    """Run an attempt in the caller's folder, so that paths mean the same."""
    os.chdir(folder)
    return attempt(config)


def _outcome(task: Any) -> Any:
    try:
        return ray.get(task)
    except RayError as error:
        return WorkerDiedError(f"worker died: {reason(error)}")


def reason(error: Exception) -> str:
    """Return the last line of a Ray error, without the other machine's traceback."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[-1] if lines else type(error).__name__
