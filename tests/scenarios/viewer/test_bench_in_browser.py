"""Test of the viewer's bench, in its own file: it starts a browser, and only one can run."""

import pytest

from scenarios.bench.viewer import WAITS, WITHIN_S, bench_viewer, watched
from scenarios.viewer.chromium import missing
from tests.scenarios.viewer.sessions import SEED


@pytest.mark.parametrize("clicks", [40, 1000])
def test_the_watched_episode_lasts_until_the_last_click_however_long_each_takes(clicks):
    assert watched(SEED, clicks).task_cap_s > clicks * WAITS * WITHIN_S


@pytest.mark.browser
@pytest.mark.skipif(bool(missing()), reason=missing() or "there is one")
def test_the_bench_measures_speed_and_waits_in_a_browser():
    speed, waits = bench_viewer(seed=SEED, repeats=1, clicks=1)
    assert speed.row_count == 2
    assert waits.row_count == 2
