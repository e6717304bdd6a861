"""Run attempts in parallel, in processes of this machine or of a cluster."""

from collections import deque
from collections.abc import Callable, Generator, Sequence
from typing import Protocol, TypeVar

from scenarios.files.errors import WorkerDiedError

Config = TypeVar("Config")
Result = TypeVar("Result")
Given = TypeVar("Given", contravariant=True)
Got = TypeVar("Got", covariant=True)


class WorkerPool(Protocol[Given, Got]):
    """Workers that each run one attempt at a time; attempts have numbers."""

    @property
    def n_busy(self) -> int:
        """Return how many attempts are running."""
        ...

    def begin(self, number: int, config: Given) -> None:
        """Start an attempt on a worker."""
        ...

    def ended(self) -> Sequence[tuple[int, Got | WorkerDiedError]]:
        """Wait until some attempts have ended; return their numbers and results."""
        ...

    def leave(self) -> None:
        """Interrupt running attempts, as Ctrl-C does, wait until they are saved, and end."""
        ...


def run_side_by_side(
    attempt: Callable[[Config], Result],
    configs: Sequence[Config],
    workers: int,
    after_death: Callable[[Config, WorkerDiedError], Result],
    cluster: str | None = None,
) -> Generator[Result, None, None]:
    """Yield each attempt's result as it ends, at most `workers` of them at once.

    An attempt whose worker died is repeated once; `after_death` makes the result if it dies again.
    The workers are other processes, which get `attempt` by pickle: on this machine or, with
    `cluster` (HOST:PORT), on a Ray cluster. Closing the iterator early interrupts them, and they
    save what they have recorded.
    """
    pool = _pool(attempt, cluster)
    waiting, again = deque(range(len(configs))), set[int]()

    def fill() -> None:
        while waiting and pool.n_busy < workers:
            number = waiting.popleft()
            pool.begin(number, configs[number])

    try:
        fill()
        while pool.n_busy:
            for number, outcome in pool.ended():
                died = isinstance(outcome, WorkerDiedError)
                retry = died and number not in again
                if retry:
                    again.add(number)
                    waiting.appendleft(number)
                fill()
                if not retry:
                    yield after_death(configs[number], outcome) if died else outcome
    finally:
        pool.leave()


def _pool(attempt: Callable[[Config], Result], cluster: str | None) -> WorkerPool[Config, Result]:
    if cluster is None:
        from scenarios.workers.local_processes import LocalProcesses

        return LocalProcesses(attempt)
    from scenarios.workers.ray_workers import RayWorkers

    return RayWorkers(attempt, cluster)
