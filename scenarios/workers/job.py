"""Say what a pool of workers does, on this machine or on a cluster."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, TypeVar

from scenarios.files.errors import WorkerDiedError

Got = TypeVar("Got", covariant=True)


class Job(NamedTuple):
    """An attempt to be made.

    Attributes:
        config: The input of the attempt.
        repeated: Whether a worker has died of it before.
    """

    config: Any
    repeated: bool


class WorkerPool(Protocol[Got]):
    """Workers that each run one job at a time."""

    @property
    def n_busy(self) -> int:
        """Return how many jobs are running."""
        ...

    def begin(self, job: Job) -> None:
        """Start a job on a worker."""
        ...

    def wait(self) -> None:
        """Wait until some jobs have ended."""
        ...

    def ended(self) -> Sequence[tuple[Job, Got | WorkerDiedError]]:
        """Return the jobs that have ended, and their results."""
        ...

    def leave(self) -> Sequence[Got]:
        """Interrupt running jobs, as Ctrl-C does, wait until they are saved, and end all workers.

        Return the results of jobs that finished before the interruption.
        """
        ...
