"""Many trials, side by side if asked, with a bar that shows how far they are."""

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from typing import TypeVar

from rich.console import Console
from rich.progress import track

from scenarios.errors import WorkerDiedError
from scenarios.pool import run_side_by_side

Result = TypeVar("Result")


def run_all(
    what: str,
    seeds: Sequence[int],
    workers: int,
    attempt: Callable[[int], Result],
    lost: Callable[[int, WorkerDiedError], Result],
) -> list[Result]:
    """The results in the order they came; `lost` gives that of a trial whose worker died."""
    with closing(_results(seeds, workers, attempt, lost)) as results:
        console = Console(stderr=True)
        return list(track(results, what, total=len(seeds), console=console, transient=True))


def _results(
    seeds: Sequence[int],
    workers: int,
    attempt: Callable[[int], Result],
    lost: Callable[[int, WorkerDiedError], Result],
) -> Generator[Result, None, None]:
    if workers > 1:
        yield from run_side_by_side(attempt, seeds, workers, lost)
    else:
        yield from map(attempt, seeds)
