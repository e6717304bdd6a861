"""Tests of the monitor: an event for each new excess, and the peak of every reading."""

from hypothesis import given
from hypothesis import strategies as st

from tissue_sim.surgery.injury import InjuryMonitor, LimitReading

VALUES = st.lists(st.floats(0.0, 10.0), min_size=1, max_size=30)


def watched(monitor: InjuryMonitor, values: list[float], limit: float) -> InjuryMonitor:
    for k, value in enumerate(values):
        monitor.watch(iter([LimitReading(event="pinch", value=value, limit=limit)]), float(k))
    return monitor


@given(values=VALUES)
def test_the_peak_is_the_largest_value_whether_or_not_it_hurts(values: list[float]) -> None:
    monitor = watched(InjuryMonitor(), values, limit=5.0)
    assert monitor.peaks["pinch"].value == max(values)
    assert bool(monitor.events) == (max(values) > 5.0)


@given(first=VALUES, then=VALUES)
def test_a_monitor_continues_where_the_record_left_off(
    first: list[float], then: list[float]
) -> None:
    whole = watched(InjuryMonitor(), first + then, limit=5.0)
    before = watched(InjuryMonitor(), first, limit=5.0)
    after = watched(
        InjuryMonitor(before.events, before.broken, before.peaks.values()), then, limit=5.0
    )
    assert after.peaks == whole.peaks
    assert [e.value for e in after.events] == [e.value for e in whole.events]


def test_where_the_limit_changes_the_peak_is_nearest_to_its_own_limit() -> None:
    monitor = InjuryMonitor()
    for value, limit in ((4.0, 8.0), (3.0, 4.0), (5.0, 8.0)):  # a partial cut weakens the wall
        monitor.watch(iter([LimitReading(event="avulsion", value=value, limit=limit)]), 0.0)
    assert monitor.peaks["avulsion"] == LimitReading(event="avulsion", value=3.0, limit=4.0)


@given(values=VALUES)
def test_what_has_no_tolerance_has_no_peak(values: list[float]) -> None:
    monitor = watched(InjuryMonitor(), values, limit=0.0)
    assert monitor.peaks == {}
    assert bool(monitor.events) == (max(values) > 0.0)
