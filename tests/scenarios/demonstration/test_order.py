"""Tests of the order: every order has all tasks, and each tube's tasks in their sequence."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planner.procedure.cholecystectomy import TASKS
from scenarios.demonstration.mix import shuffled_order


@given(st.integers(0, 2**32 - 1))
def test_every_task_is_there_and_those_of_a_tube_follow_each_other(seed):
    usual, third = TASKS[:17], TASKS[17:]
    order = shuffled_order(np.random.default_rng(seed))
    assert order[0] == TASKS[0]
    assert order[-len(third) :] == third
    assert order[-len(third) - 1] == usual[-1]
    body = order[1 : -len(third) - 1]
    for tube in ("left", "right"):
        assert [t for t in body if t.tube == tube] == [t for t in TASKS if t.tube == tube]
    for task, then in zip(body[::2], body[1::2], strict=True):
        assert task.kind in ("clip", "cut")
        assert then == TASKS[TASKS.index(task) + 1]


def test_either_tube_may_come_first():
    first = {shuffled_order(np.random.default_rng(k))[1].tube for k in range(20)}
    assert first == {"left", "right"}
