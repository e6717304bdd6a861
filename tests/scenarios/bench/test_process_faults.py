"""Tests of commands that are hurt while they run; more of them: `process_faults(0, 60)`."""

import pytest

from scenarios.bench.trials.fault_trial import process_faults


@pytest.mark.slow
def test_nothing_that_was_finished_is_lost_and_nothing_is_left():
    broken = [outcome for outcome in process_faults(0, 6) if outcome.wrong]
    assert broken == []
