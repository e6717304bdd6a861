"""The viewer's bench, in a file of its own: it starts a browser, and there can be but one."""

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
