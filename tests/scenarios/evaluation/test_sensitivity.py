"""Tests of the sensitivity table: a reading of peaks and margins, which never invents a pass."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.evaluation.page import page
from scenarios.evaluation.report import report_of
from scenarios.evaluation.sensitivity import FACTORS, passes, sensitivity, threshold_of
from scenarios.loop.results import CallResult, InjuryResult, PeakResult, summarise
from tests.scenarios.evaluation.made_up import MADE_WITH, NOWHERE, episode, plan, results_of
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.patient.variants import patient_of
from tissue_sim.surgery import abuses, injuries
from tissue_sim.surgery.injury import LimitReading
from tissue_sim.surgery.tear import worst_load
from tissue_sim.world import World

COMPLETE = replace(episode(plan("nominal").due({})[0]), peaks=())
LIMITS = {"crush of duct": 2.5, "crush of artery": 2.5, "blunt force": 1.5, "traction": 5.0}
DEMANDS = st.fixed_dictionaries({event: st.floats(0.0, 3.0) for event in LIMITS})


def with_demands(demands, *, complete=True):
    """Return an episode whose quantities reached these shares of their limits."""
    peaks = tuple(
        PeakResult(event=e, value=d * LIMITS[e], limit=LIMITS[e]) for e, d in demands.items()
    )
    injuries = tuple(
        InjuryResult(event=p.event, time_s=1.0, value=p.value, limit=p.limit)
        for p in peaks
        if p.value > p.limit
    )
    tasks = COMPLETE.tasks if complete else COMPLETE.tasks[:5]
    success = complete and not injuries
    return replace(COMPLETE, success=success, tasks=tasks, injuries=injuries, peaks=peaks)


@given(demands=DEMANDS, complete=st.booleans())
def test_at_the_limits_themselves_an_episode_passes_if_it_did(demands, complete):
    result = with_demands(demands, complete=complete)
    assert all(passes(result, threshold_of(e), 1.0) == result.success for e in LIMITS)


def all_readings(patient: str) -> tuple[LimitReading, ...]:
    """Return every quantity that is limited in every step, as it is before anything moves."""
    world = World()
    world.reset(patient_of(20_000, patient))
    world.tissue.load_walls()
    loads = [worst_load(world.tubes, tube) for tube in world.organ.hollow]
    r = world.record
    return (
        *injuries.wall_loads(world, loads),
        *injuries.other_readings(world, r, r.grasp, 0.0),
        *abuses.readings(world, r, 0.0),
    )


def test_at_the_limits_themselves_no_injury_is_forgiven_whatever_else_is_named_alike():
    readings = all_readings("two-arteries")
    peaks = tuple(PeakResult(event=r.event, value=0.0, limit=r.limit) for r in readings if r.limit)
    for reading in readings:
        injury = InjuryResult(
            event=reading.event, time_s=1.0, value=2.0 * reading.limit + 1.0, limit=reading.limit
        )
        beyond = tuple(
            replace(p, value=injury.value) if p.event == injury.event else p for p in peaks
        )
        hurt = replace(COMPLETE, success=False, injuries=(injury,), peaks=beyond)
        names = {threshold_of(peak.event) for peak in peaks}
        assert not [name for name in names if passes(hurt, name, 1.0)], reading.event


@given(demands=DEMANDS)
def test_a_laxer_limit_never_loses_a_pass_and_a_stricter_one_never_wins_one(demands):
    result = with_demands(demands)
    for event in LIMITS:
        half, same, double = (passes(result, threshold_of(event), f) for f in FACTORS)
        assert half <= same <= double


@pytest.mark.parametrize(
    ("crush", "traction", "passed"),
    [
        (0.4, 0.0, (1, 1, 1)),
        (0.6, 0.0, (0, 1, 1)),
        (1.5, 0.0, (0, 0, 1)),
        (2.5, 0.0, (0, 0, 0)),
        (1.5, 1.5, (0, 0, 0)),  # a laxer crush does not forgive the traction
        (0.4, 1.5, (0, 0, 0)),
    ],
)
def test_the_crush_of_any_tube_counts_against_one_limit(crush, traction, passed):
    demands = {"crush of duct": 0.1, "crush of artery": crush, "traction": traction}
    found = {row.threshold: row for row in sensitivity([with_demands(demands)])}
    assert found["crush"].passed == passed
    assert found["crush"].limit == 2.5
    assert found["crush"].closest == pytest.approx(crush)


def test_what_was_not_completed_does_not_pass_however_lax_the_limit():
    result = with_demands({"traction": 1.5}, complete=False)
    assert not any(passes(result, "traction", factor) for factor in FACTORS)
    without_third = replace(with_demands({"traction": 1.5}), tubes=TUBES)
    assert not any(passes(without_third, "traction", factor) for factor in FACTORS)


def test_an_injury_without_tolerance_is_never_forgiven():
    leak = InjuryResult(event="leak", time_s=1.0, value=1e-9, limit=0.0)
    result = with_demands({"traction": 0.1})
    result = replace(result, success=False, injuries=(leak,))
    assert [row.threshold for row in sensitivity([result])] == ["traction"]
    assert not passes(result, "traction", 2.0)


@pytest.mark.parametrize(("cuff_mm", "passed"), [(2.5, (1, 1, 1)), (1.5, (1, 1, 0))])
def test_a_lower_limit_is_stricter_when_it_is_larger(cuff_mm, passed):
    cuff = PeakResult(event="cuff", value=1e-3 * cuff_mm, limit=1e-3, at_least=True)
    (row,) = sensitivity([replace(COMPLETE, peaks=(cuff,))])
    assert row.passed == passed


def test_errors_and_results_without_peaks_make_no_rows():
    error = replace(with_demands({"traction": 0.6}), success=False, error="ValueError")
    assert sensitivity([error]) == ()
    assert sensitivity([COMPLETE]) == ()


def test_the_same_episodes_count_as_in_the_pass_rate():
    """The anatomy calls for a person in one; without need, a call counts as not passed."""
    passed = with_demands({"traction": 0.6})
    rightly, needless = (
        replace(passed, success=False, tasks=(), call=CallResult(reason="", in_time=True, needed=n))
        for n in (True, False)
    )
    episodes = [passed, rightly, needless]
    (row,) = sensitivity(episodes)
    assert row.episodes == summarise(episodes).counted == 2
    assert row.passed == (0, 1, 1)


def test_a_limit_that_differs_between_patients_is_not_given_as_one():
    two = [
        replace(COMPLETE, peaks=(PeakResult(event="avulsion of duct", value=1.0, limit=limit),))
        for limit in (4.0, 5.0)
    ]
    (row,) = sensitivity(two)
    assert row.limit is None
    assert row.closest == pytest.approx(0.25)


def test_the_page_tells_the_rates_and_that_nothing_was_run_again():
    report = report_of(plan("nominal"), results_of(plan("nominal"), episode), NOWHERE)
    (row,) = report.arms["first"].suites["nominal"].sensitivity
    html = page(report, MADE_WITH)
    assert "runs none" in html
    for passed in row.passed:
        assert f"{passed} of {row.episodes}" in html
    assert row.passed[0] < row.passed[1] == row.episodes
