"""Tests of the bench of the stack: its stages add up, and timing changes no command."""

from contextlib import nullcontext

import numpy as np
import pytest

from scenarios.bench.stack import Loop, begun, bench_stack, watch_loop

SEED, STEPS = 10_004, 60


def test_timing_the_stack_changes_nothing_and_its_stages_add_up():
    def run(*, timed):
        loop = Loop(begun(SEED))
        with watch_loop(loop) if timed else nullcontext() as stopwatch:
            steps = [loop.step() for _ in range(STEPS)]
        return [(step.command.joints, step.observation.vector()) for step in steps], stopwatch

    (plain, _), (timed, stopwatch) = run(timed=False), run(timed=True)
    np.testing.assert_equal(timed, plain)
    assert stopwatch is not None
    shares = [
        sum(stages.values()) / whole_s
        for stages, whole_s in zip(stopwatch.stages_s, stopwatch.whole_s, strict=True)
    ]
    assert np.median(shares) == pytest.approx(1.0, abs=0.02)  # the stopwatch takes the rest
    for name in stopwatch.stages_s[0]:
        assert sum(stages[name] for stages in stopwatch.stages_s) > 0.0, name


@pytest.mark.slow
def test_the_bench_tells_stages_speed_and_start(capfd):
    table, speed, start = bench_stack(seed=SEED, steps=2)
    assert table.row_count == 10  # eight stages, the rest and the whole
    assert "times real time" in speed
    assert "to the first control step" in start
