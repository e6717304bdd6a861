"""Run attempts in parallel, in processes of this machine or of a cluster."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from typing import TypeVar

from scenarios.files.errors import WorkerDiedError
from scenarios.workers.job import Job, WorkerPool
from scenarios.workers.process import counting, saving

Config = TypeVar("Config")
Result = TypeVar("Result")


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


def run_each(
    attempt: Callable[[Config], Result],
    configs: Iterable[Config],
    workers: int,
    after_death: Callable[[Config, WorkerDiedError], Result],
    cluster: str | None = None,
    here: Callable[[Config], Result] | None = None,
) -> Generator[Result, None, None]:
    """Yield each attempt's result, by `run_side_by_side` or by `here`.

    `here` makes the attempts in this process if neither several workers nor a cluster are wanted.
    Between the first save of an attempt and the end of the caller's note of it, signals wait.
    """
    if here is None or workers > 1 or cluster is not None:
        yield from run_side_by_side(attempt, configs, workers, after_death, cluster)
        return
    for config in configs:
        with counting():
            yield here(config)


def _next(again: deque[Job], coming: Iterator[Job]) -> Job | None:
    return again.popleft() if again else next(coming, None)


def _pool(attempt: Callable[[Config], Result], cluster: str | None) -> WorkerPool[Result]:
    if cluster is None:
        from scenarios.workers.local_processes import LocalProcesses

        return LocalProcesses(attempt)
    from scenarios.workers.ray_workers import RayWorkers

    return RayWorkers(attempt, cluster)
