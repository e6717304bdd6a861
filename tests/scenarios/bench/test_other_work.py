"""Tests of the measurement of other work: a busy child counts, this process does not."""

import sys
from collections.abc import Callable
from subprocess import Popen
from time import process_time, sleep

from scenarios.bench.other_work import other_work


def keep_busy(own_s: float) -> None:
    start_s = process_time()
    while process_time() - start_s < own_s:
        pass


def min_cores(work: Callable[[float], None]) -> float:
    """Return the minimum of a few tries, because the machine may be busy."""
    tries = []
    for _ in range(5):
        with other_work() as others:
            work(0.2)
        tries.append(others.cores)
    return min(tries)


def test_this_process_does_not_count() -> None:
    assert min_cores(keep_busy) < min_cores(sleep) + 0.5


def test_a_child_counts() -> None:
    child = Popen([sys.executable, "-c", "while True: pass"])
    try:
        assert min_cores(keep_busy) > 0.3
    finally:
        child.kill()
        child.wait()
