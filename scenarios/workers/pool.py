"""Run attempts in parallel, in processes of this machine or of a cluster."""

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from typing import Any, NamedTuple, Protocol, TypeVar

from scenarios.files.errors import WorkerDiedError
from scenarios.workers.process import saving

Config = TypeVar("Config")
Result = TypeVar("Result")
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


def run_side_by_side(
    attempt: Callable[[Config], Result],
    configs: Iterable[Config],
    workers: int,
    after_death: Callable[[Config, WorkerDiedError], Result],
    cluster: str | None = None,
) -> Generator[Result, None, None]:
    """Yield each attempt's result as it ends, at most `workers` of them at once.

    An attempt whose worker died is repeated once; `after_death` makes the result if it dies again.
    The workers are other processes, which get `attempt` by pickle: on this machine or, with
    `cluster` (HOST:PORT), on a Ray cluster. Closing the iterator early interrupts the attempts, and
    they save their recordings. A signal does the same. After a signal, the results of finished
    attempts are yielded before KeyboardInterrupt is raised.
    """
    pool = _pool(attempt, cluster)
    coming, again = (Job(config, repeated=False) for config in configs), deque[Job]()

    def fill() -> None:
        while pool.n_busy < workers and (due := _next(again, coming)) is not None:
            pool.begin(due)

    try:
        fill()
        while pool.n_busy:
            pool.wait()
            with saving():  # what is received is passed on
                for job, outcome in pool.ended():
                    died = isinstance(outcome, WorkerDiedError)
                    if retry := died and not job.repeated:
                        again.append(job._replace(repeated=True))
                    fill()
                    if not retry:
                        yield after_death(job.config, outcome) if died else outcome
    except KeyboardInterrupt:
        with saving():
            yield from pool.leave()
        raise
    finally:
        with saving():
            pool.leave()


def _next(again: deque[Job], coming: Iterator[Job]) -> Job | None:
    return again.popleft() if again else next(coming, None)


def _pool(attempt: Callable[[Config], Result], cluster: str | None) -> WorkerPool[Result]:
    if cluster is None:
        from scenarios.workers.local_processes import LocalProcesses

        return LocalProcesses(attempt)
    from scenarios.workers.ray_workers import RayWorkers

    return RayWorkers(attempt, cluster)
