"""Attempts side by side, in processes of this machine or of a cluster of many."""

from collections import deque
from collections.abc import Callable, Generator, Sequence
from typing import Protocol, TypeVar

from scenarios.files.errors import WorkerDiedError

Config = TypeVar("Config")
Result = TypeVar("Result")
Given = TypeVar("Given", contravariant=True)
Got = TypeVar("Got", covariant=True)


class Crew(Protocol[Given, Got]):
    """Workers, somewhere, each at one attempt at a time; attempts are known by numbers."""

    @property
    def n_busy(self) -> int:
        """How many attempts are under way."""
        ...

    def begin(self, number: int, config: Given) -> None:
        """Has a worker at it, if need be a new one."""
        ...

    def ended(self) -> Sequence[tuple[int, Got | WorkerDiedError]]:
        """Waits until some attempts have ended; returns what came of them."""
        ...

    def leave(self) -> None:
        """Interrupts what is under way, as Ctrl-C does, lets it be saved, and dismisses all."""
        ...


def run_side_by_side(
    attempt: Callable[[Config], Result],
    configs: Sequence[Config],
    workers: int,
    after_death: Callable[[Config, WorkerDiedError], Result],
    cluster: str | None = None,
) -> Generator[Result, None, None]:
    """Yields each attempt's result as it ends, at most `workers` of them at once.

    One whose worker died is made once more; `after_death` gives the result of one that died again.
    The workers are other interpreters, to which `attempt` goes by pickle: of this machine or, by
    the address HOST:PORT, of a Ray cluster. Closing the iterator early interrupts them, and they
    save what they have recorded.
    """
    crew = _crew(attempt, cluster)
    waiting, again = deque(range(len(configs))), set[int]()

    def fill() -> None:
        while waiting and crew.n_busy < workers:
            number = waiting.popleft()
            crew.begin(number, configs[number])

    try:
        fill()
        while crew.n_busy:
            for number, outcome in crew.ended():
                died = isinstance(outcome, WorkerDiedError)
                retry = died and number not in again
                if retry:
                    again.add(number)
                    waiting.appendleft(number)
                fill()
                if not retry:
                    yield after_death(configs[number], outcome) if died else outcome
    finally:
        crew.leave()


def _crew(attempt: Callable[[Config], Result], cluster: str | None) -> Crew[Config, Result]:
    if cluster is None:
        from scenarios.workers.local_processes import CrewProcesses

        return CrewProcesses(attempt)
    from scenarios.workers.ray_workers import CrewRay

    return CrewRay(attempt, cluster)
