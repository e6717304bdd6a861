"""Tests of what is due: what is seen to be done ends a task, whatever the network asks for."""

from dataclasses import replace

import numpy as np
import pytest

from planner.base import PATIENCE_S, PLANNING_PERIOD_S
from planner.procedure.cholecystectomy import GRAB, TASKS
from planner.procedure.task import Task
from planner.rules.task_gate import GRAB_S, GRASPED_S, TaskClock, gate_task
from planner.scene.predicates import FIRM_TRACTION_N
from tests.planner.observations import at_work, writable
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import GRASP_MAX_JAW_RAD
from tissue_sim.tools.arms import LEFT_ARM

NAMED = {task.text: task for task in TASKS}
FIRST, SECOND = NAMED["clipping first clip left tube"], NAMED["clipping second clip left tube"]
BACK = NAMED["going back first clip left tube"]
CUT, BACK_FROM_CUT = TASKS[7], TASKS[8]
BEFORE_S, LATE_S = PATIENCE_S - 1.0, PATIENCE_S + 0.1


def clock(since_s: float, **others_s: float) -> TaskClock:
    """Return a clock that shows these times."""
    made = TaskClock()
    for name, value_s in ({"since_s": since_s} | others_s).items():
        setattr(made, name, value_s)
    return made


@pytest.mark.parametrize("asked", TASKS)
@pytest.mark.parametrize(
    ("given", "now"),
    [(FIRST, at_work()), (BACK, at_work(1)), (CUT, at_work(3)), (SECOND, at_work(1))],
)
def test_what_is_not_done_goes_on(given: Task, now: Observation, asked: Task) -> None:
    assert gate_task(asked, given, now, clock(BEFORE_S)) == given


@pytest.mark.parametrize("asked", TASKS)
@pytest.mark.parametrize(("given", "now"), [(FIRST, at_work(1)), (SECOND, at_work(2))])
def test_a_clip_that_is_seen_is_left_by_the_way_back(
    given: Task, now: Observation, asked: Task
) -> None:
    assert gate_task(asked, given, now, clock(0.0)) == TASKS[given.index]


@pytest.mark.parametrize("asked", TASKS[1:])
def test_an_arm_that_is_back_goes_on_with_what_is_not_done(asked: Task) -> None:
    assert gate_task(asked, BACK, at_work(1, back=True), clock(0.0)) == SECOND
    assert gate_task(asked, BACK, at_work(0, back=True), clock(0.0)) == FIRST  # the clip fell


@pytest.mark.parametrize("asked", TASKS[1:])
def test_what_takes_too_long_is_tried_again(asked: Task) -> None:
    assert gate_task(asked, CUT, at_work(3), clock(LATE_S)) == BACK_FROM_CUT
    assert gate_task(asked, BACK_FROM_CUT, at_work(3, back=True), clock(0.0)) == CUT
    assert gate_task(asked, BACK, at_work(1), clock(LATE_S)) == SECOND  # it stopped just short


@pytest.mark.parametrize("asked", TASKS)
@pytest.mark.parametrize(("looks", "leaves"), [(1, False), (2, True)])
def test_a_gallbladder_that_is_twice_seen_to_have_slipped_is_grabbed_again(
    asked: Task, looks: int, leaves: bool
) -> None:
    slipped = clock(1.0, slipped_s=looks * PLANNING_PERIOD_S)
    assert gate_task(asked, FIRST, at_work(), slipped) == (BACK if leaves else FIRST)
    if asked != GRAB:
        assert gate_task(asked, BACK, at_work(back=True), slipped) == (GRAB if leaves else FIRST)


def test_a_gallbladder_slips_until_it_is_held_again_and_never_after_a_cut() -> None:
    watch = TaskClock()
    for time_s, held, slipped_s in ((0, True, 0), (1, False, 1), (2, False, 2), (3, True, 0)):
        watch.update(replace(at_work(held=held), time_s=float(time_s)))
        assert watch.slipped_s == slipped_s
    watch.update(replace(at_work(held=False), time_s=4.0, severed=np.array([True, False, False])))
    assert watch.slipped_s == 0.0


def test_it_grabs_again_where_the_network_asks_for_it_and_the_arm_is_back() -> None:
    assert gate_task(GRAB, BACK, at_work(), clock(1.0)) == BACK
    assert gate_task(GRAB, BACK, at_work(back=True), clock(1.0)) == GRAB


def test_a_grab_is_done_when_it_is_seen_to_be_good_whatever_the_network_says() -> None:
    for given in (None, GRAB):
        assert gate_task(GRAB, given, at_work(back=True), clock(60.0)) == GRAB
    for asked in TASKS[1:]:
        assert (
            gate_task(asked, GRAB, at_work(), clock(0.9 * GRAB_S, grasped_s=0.9 * GRASPED_S))
            == GRAB
        )
        assert (
            gate_task(asked, GRAB, at_work(), clock(0.9 * GRAB_S, grasped_s=1.1 * GRASPED_S))
            == FIRST
        )


def test_that_a_grab_is_done_which_takes_too_long_is_up_to_the_network() -> None:
    assert {gate_task(asked, GRAB, at_work(), clock(1.1 * GRAB_S)) for asked in TASKS[1:]} == {
        FIRST
    }
    assert {gate_task(asked, None, at_work(), clock(1.0)) for asked in TASKS[1:]} == {FIRST}


@pytest.mark.parametrize(("share", "goes_on"), [(0.9, True), (1.1, False)])
def test_a_grab_goes_on_while_the_pull_is_too_weak_to_be_sure(share: float, goes_on: bool) -> None:
    now = writable(at_work())
    now.forces_n[LEFT_ARM, 1] = share * FIRM_TRACTION_N
    assert gate_task(FIRST, GRAB, now, clock(LATE_S)) == (GRAB if goes_on else FIRST)


def test_a_grab_goes_on_while_nothing_is_held() -> None:
    assert {gate_task(asked, GRAB, at_work(held=False), clock(LATE_S)) for asked in TASKS} == {GRAB}


@pytest.mark.parametrize("given", [None, GRAB])
def test_a_grasp_that_has_surely_been_good_is_done(given: Task | None) -> None:
    assert gate_task(GRAB, given, at_work(), clock(3.0, grasped_s=0.9 * GRASPED_S)) == GRAB
    assert gate_task(GRAB, given, at_work(), clock(3.0, grasped_s=1.1 * GRASPED_S)) == FIRST


@pytest.mark.parametrize(("wide", "goes_on"), [(1.1, True), (0.9, False)])
def test_a_grab_goes_on_while_the_jaws_are_too_wide(wide: float, goes_on: bool) -> None:
    now = writable(at_work())
    now.joints[LEFT_ARM, -1] = wide * GRASP_MAX_JAW_RAD
    assert gate_task(FIRST, GRAB, now, clock(LATE_S)) == (GRAB if goes_on else FIRST)
    assert gate_task(FIRST, GRAB, now, clock(LATE_S, pulled_s=LATE_S)) == FIRST


@pytest.mark.parametrize("given", [None, GRAB])
def test_a_grasp_that_has_pulled_for_too_long_counts_as_done(given: Task | None) -> None:
    assert gate_task(GRAB, given, at_work(), clock(LATE_S, pulled_s=BEFORE_S)) == GRAB
    assert gate_task(GRAB, given, at_work(), clock(LATE_S, pulled_s=LATE_S)) == FIRST


def test_when_all_is_cut_the_last_way_back_is_the_last_task() -> None:
    now = replace(at_work(3, 3, back=True), severed=np.array([True, True, False]))
    assert {gate_task(asked, TASKS[-1], now, clock(1.0)) for asked in TASKS[1:]} == {TASKS[-1]}
