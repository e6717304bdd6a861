"""`calot bench`: how fast and how exact; a new bench is a new file and one line in BENCHES."""

import os
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import Annotated

from rich.console import Console
from tyro.conf import Positional

from scenarios.commands.arguments import at_least, one_of

BENCHES: dict[str, str] = {
    "world": "scenarios.bench_world:bench_world",
    "accuracy": "scenarios.bench_accuracy:bench_accuracy",
}
"""A function each, of the seed and the number of control steps, that returns what to print."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True, kw_only=True)
class Bench:
    """Measure on one core how fast a part of Calot runs, or how exact it is."""

    part: Positional[Annotated[str, one_of(BENCHES)]]
    """What to measure."""
    seed: Annotated[int, at_least(0)] = 20_000
    """Of the anatomy."""
    steps: Annotated[int, at_least(1)] = 300
    """Control steps to measure, after the warm-up or the retraction."""

    def execute(self) -> int:
        """Measures and reports; returns 0."""
        os.environ.update(dict.fromkeys(ONE_THREAD, "1"))  # read when the libraries are imported
        bench = resolve_name(BENCHES[self.part])
        with Console(stderr=True).status(f"measuring: {self.part}"):
            report = bench(seed=self.seed, steps=self.steps)
        console = Console()
        for part in (*report, machine_line()):
            console.print(part, highlight=False, soft_wrap=isinstance(part, str))
        return 0


def machine_line() -> str:
    """Returns what else the machine was doing, without which a time says little."""
    loads = ", ".join(f"{load:.2f}" for load in os.getloadavg())
    cores = len(os.sched_getaffinity(0))
    return f"machine: {cores} cores, load {loads} over the last 1, 5 and 15 minutes"
