"""A pool of workers on the machines of a Ray cluster, of which this machine is a node.

A check before any work tells the nodes that cannot do it.

The current folder, and the files that the command names, lie on a disk that all nodes share.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any, TypeVar

import ray  # pyright: ignore[reportMissingImports]
from ray.exceptions import RayError  # pyright: ignore[reportMissingImports]
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy  # pyright: ignore

from scenarios.files.errors import WorkerDiedError
from scenarios.workers.job import Job, WorkerPool
from scenarios.workers.local_processes import STOP_TIMEOUT_S
from tissue_sim.constants import WORLD_VERSION

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


# Can the nodes do the work?

WITHIN_S = 120.0  # a node's first task imports everything


def obstacles(folders: Sequence[Path]) -> Iterator[str]:
    """Yield why nodes cannot work: another version of Calot, none, or a folder not shared."""
    with ExitStack() as stack:
        marks = [
            stack.enter_context(NamedTemporaryFile(dir=_existing(folder))).name
            for folder in folders
        ]
        nodes = [node for node in ray.nodes() if node["Alive"] and node["Resources"].get("CPU")]
        answers = [_asked(node["NodeID"], marks) for node in nodes]
        for node, answer in zip(nodes, answers, strict=True):
            if obstacle := _received(answer):
                yield f"node {node['NodeManagerAddress']}: {obstacle}"


def _existing(folder: Path) -> Path:
    folder = folder.absolute()
    return next(path for path in (folder, *folder.parents) if path.is_dir())


def _asked(node: str, marks: Sequence[str]) -> ray.ObjectRef:
    there = NodeAffinitySchedulingStrategy(node, soft=False)
    task = ray.remote(num_cpus=0)(_obstacle).options(scheduling_strategy=there)
    return task.remote(WORLD_VERSION, marks)


def _obstacle(world_version: int, marks: Sequence[str]) -> str | None:
    """Return why this node cannot work; runs on the node itself."""
    if world_version != WORLD_VERSION:
        return f"its Calot has world version {WORLD_VERSION}, not {world_version}"
    unseen = [str(Path(mark).parent) for mark in marks if not Path(mark).exists()]
    return f"it does not see {unseen[0]}: all nodes must share this disk" if unseen else None


def _received(answer: ray.ObjectRef) -> str | None:
    try:
        return ray.get(answer, timeout=WITHIN_S)
    except RayError as error:
        return reason(error)
