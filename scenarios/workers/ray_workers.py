"""A pool of workers on the machines of a Ray cluster, of which this machine is a node.

The current folder, and the files that the command names, lie on a disk that all nodes share.
"""

import os
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import ray  # pyright: ignore[reportMissingImports]
from ray.exceptions import RayError  # pyright: ignore[reportMissingImports]

from scenarios.files.errors import WorkerDiedError
from scenarios.workers.local_processes import STOP_TIMEOUT_S

Config = TypeVar("Config")
Result = TypeVar("Result")


class RayWorkers(Generic[Config, Result]):
    """A pool of Ray tasks with one core each; Ray manages their processes."""

    def __init__(self, attempt: Callable[[Config], Result], address: str) -> None:
        """Join the cluster whose head answers at `address`, HOST:PORT."""
        connect(address)
        self._attempt, self._folder = attempt, os.getcwd()
        self._numbers: dict[ray.ObjectRef, int] = {}

    @property
    def n_busy(self) -> int:
        """Return how many attempts are running."""
        return len(self._numbers)

    def begin(self, number: int, config: Config) -> None:
        """Start an attempt on any node; Ray must not retry it, so that deaths are counted."""
        task = ray.remote(num_cpus=1, max_retries=0)(_attempted)
        self._numbers[task.remote(self._folder, self._attempt, config)] = number

    def wait(self) -> None:
        """Wait until some attempts have ended."""
        ray.wait(list(self._numbers), num_returns=1)

    def ended(self) -> list[tuple[int, Result | WorkerDiedError]]:
        """Return the numbers and results of attempts that have ended."""
        done, _ = ray.wait(list(self._numbers), num_returns=len(self._numbers), timeout=0.0)
        return [(self._numbers.pop(task), _outcome(task)) for task in done]

    def leave(self) -> list[Result]:
        """Interrupt running attempts and wait until they are saved.

        Return the results of attempts that finished before the interruption.
        """
        under_way, self._numbers = list(self._numbers), {}
        for task in under_way:
            ray.cancel(task)
        if not under_way:
            return []
        done, _ = ray.wait(under_way, num_returns=len(under_way), timeout=STOP_TIMEOUT_S)
        last = [_outcome(task) for task in done]
        return [outcome for outcome in last if not isinstance(outcome, WorkerDiedError)]


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
