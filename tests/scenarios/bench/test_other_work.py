"""Laws of the watch on other work: a busy child counts, this process does not."""

import sys
from collections.abc import Callable
from subprocess import Popen
from time import process_time, sleep

from scenarios.bench.other_work import other_work


def toil(own_s: float) -> None:
    start_s = process_time()
    while process_time() - start_s < own_s:
        pass


def least_cores(work: Callable[[float], None]) -> float:
    """Of a few tries, as the machine has other things to do."""
    tries = []
    for _ in range(5):
        with other_work() as others:
            work(0.2)
        tries.append(others.cores)
    return min(tries)


def test_this_process_does_not_count() -> None:
    assert least_cores(toil) < least_cores(sleep) + 0.5


def test_a_child_counts() -> None:
    child = Popen([sys.executable, "-c", "while True: pass"])
    try:
        assert least_cores(toil) > 0.3
    finally:
        child.kill()
        child.wait()
