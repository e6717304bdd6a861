"""Workers on the machines of a Ray cluster, of which this one is part.

The folder that the command is called in, and the files it names, lie on a disk that all share.
"""

import os
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import ray  # pyright: ignore[reportMissingImports]
from ray.exceptions import RayError  # pyright: ignore[reportMissingImports]

from scenarios.files.errors import WorkerDiedError

Config = TypeVar("Config")
Result = TypeVar("Result")

STOP_TIMEOUT_S = 10.0  # an interrupted worker saves its recording in far less


class CrewRay(Generic[Config, Result]):
    """Ray tasks of one core each; Ray keeps their processes for the next, and waits for cores."""

    def __init__(self, attempt: Callable[[Config], Result], address: str) -> None:
        """`address`: HOST:PORT of the cluster's head, which answers."""
        connect(address)
        self._attempt, self._folder = attempt, os.getcwd()
        self._numbers: dict[ray.ObjectRef, int] = {}

    @property
    def n_busy(self) -> int:
        """How many attempts are under way."""
        return len(self._numbers)

    def begin(self, number: int, config: Config) -> None:
        """Has Ray find a place for it; that Ray does not try again by itself counts deaths once."""
        task = ray.remote(num_cpus=1, max_retries=0)(_attempted)
        self._numbers[task.remote(self._folder, self._attempt, config)] = number

    def ended(self) -> list[tuple[int, Result | WorkerDiedError]]:
        """Waits until some attempts have ended; returns what came of them."""
        done, _ = ray.wait(list(self._numbers), num_returns=1)
        return [(self._numbers.pop(task), _outcome(task)) for task in done]

    def leave(self) -> None:
        """Interrupts what is under way, lets it be saved; the rest ends with this process."""
        under_way = list(self._numbers)
        for task in under_way:
            ray.cancel(task)
        if under_way:
            ray.wait(under_way, num_returns=len(under_way), timeout=STOP_TIMEOUT_S)


def connect(address: str) -> None:
    """Joins the cluster, unless that is done.

    Raises:
        ConnectionError, RuntimeError, ValueError: It cannot be joined, and why.
    """
    if not ray.is_initialized():
        ray.init(address=address, logging_level="ERROR", log_to_driver=False)


def _attempted(folder: str, attempt: Callable[[Config], Result], config: Config) -> Result:
    """In the folder of whoever asked, so that paths mean the same."""
    os.chdir(folder)
    return attempt(config)


def _outcome(task: Any) -> Any:
    try:
        return ray.get(task)
    except RayError as error:
        return WorkerDiedError(f"worker died: {reason(error)}")


def reason(error: Exception) -> str:
    """Returns an error of Ray without the trace of the other machine."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[-1] if lines else type(error).__name__
