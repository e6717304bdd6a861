"""Print a bench's report, together with the machine that measured it."""

import os
from collections.abc import Iterable
from typing import Any

from scenarios.commands.output import output


def show(report: Iterable[Any]) -> None:
    """Print tables and lines, and the state of the machine, on which every time depends."""
    console = output()
    for part in (*report, machine_line()):
        console.print(part, highlight=False, soft_wrap=isinstance(part, str))


def machine_line() -> str:
    """Return the machine's number of cores and its load."""
    loads = ", ".join(f"{load:.2f}" for load in os.getloadavg())
    cores = len(os.sched_getaffinity(0))
    return f"machine: {cores} cores, load {loads} over the last 1, 5 and 15 minutes"
