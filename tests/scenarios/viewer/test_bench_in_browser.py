"""Test of the viewer's bench, in its own file: it starts a browser, and only one can run."""

import pytest

from scenarios.bench.viewer import bench_viewer
from scenarios.viewer.chromium import missing
from tests.scenarios.viewer.sessions import SEED


@pytest.mark.browser
@pytest.mark.skipif(bool(missing()), reason=missing() or "there is one")
def test_the_bench_measures_speed_and_waits_in_a_browser():
    speed, waits = bench_viewer(seed=SEED, repeats=1, clicks=1)
    assert speed.row_count == 2
    assert waits.row_count == 2
