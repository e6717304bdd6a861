"""Tests of the measurement of other work: a busy child counts, this process does not."""

import sys
from collections.abc import Callable
from subprocess import Popen
from time import process_time, sleep

from scenarios.bench.stopwatch import other_work


def keep_busy(own_s: float) -> None:
    start_s = process_time()
    while process_time() - start_s < own_s:
        pass


def cores(work: Callable[[float], None]) -> float:
    with other_work() as others:
        work(0.2)
    return others.cores


def test_this_process_does_not_count() -> None:
    """Take turns, and the smallest of each: the machine may be busy for a while."""
    pairs = [(cores(keep_busy), cores(sleep)) for _ in range(10)]
    busy, idle = (min(column) for column in zip(*pairs, strict=True))
    assert busy < idle + 0.5


def test_a_child_counts() -> None:
    child = Popen([sys.executable, "-c", "while True: pass"])
    try:
        assert min(cores(keep_busy) for _ in range(5)) > 0.3
    finally:
        child.kill()
        child.wait()
