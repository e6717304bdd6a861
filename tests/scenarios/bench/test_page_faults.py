"""Tests of hostile clients: each is answered or cut off, and the next stop is heard."""

import pytest

from scenarios.bench.trials.page_faults import page_faults

BAD = ("page lost", "hung", "odd answer", "closed")


@pytest.mark.parametrize("n", [5, pytest.param(300, marks=pytest.mark.slow)])
def test_the_page_outlives_hostile_clients(capfd, n):
    counts = page_faults(7, n)
    assert sum(counts.values()) == n
    assert not [what for what in counts if what.endswith(BAD)]
    assert "Traceback" not in capfd.readouterr().err
