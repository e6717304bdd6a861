"""Measure how many cores other processes use: a second thread gains nothing without a free core."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter, process_time

IDLE = (3, 4)  # of the columns of /proc/stat: user, nice, system, idle, iowait, irq, softirq, steal
COLUMNS = 8


class OtherWork:
    """`cores`: mean number of cores that other processes used in a `with` block; set at its end."""

    cores: float


@contextmanager
def other_work() -> Iterator[OtherWork]:
    """Measure the CPU time of all other processes; child processes count as others."""
    work = OtherWork()
    start_s, start_others_s = perf_counter(), _others_s()
    yield work
    others_s = max(0.0, _others_s() - start_others_s)  # the kernel counts in ticks
    work.cores = others_s / (perf_counter() - start_s)


def _others_s() -> float:
    """Return the CPU time that other processes and guests of the host have used so far, s."""
    ticks = [int(x) for x in Path("/proc/stat").read_text().split(maxsplit=COLUMNS + 1)[1:-1]]
    busy = sum(x for k, x in enumerate(ticks) if k not in IDLE)
    return busy / os.sysconf("SC_CLK_TCK") - process_time()
