"""Tests of the audit of words: is what was said obeyed as meant, and each order settled?"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.instruction import TASKS, Instruction
from scenarios.evaluation.audit import AuditLine, audit
from scenarios.evaluation.case import Case
from scenarios.loop.person.inbox import Heard, read
from scenarios.recording.recorder import Recorder
from scenarios.suites import SUITES, Condition, Saying
from tests.scenarios.evaluation.made_up import FIRST
from tests.scenarios.recording.made_up_step import random_step

THREE = "clip the artery, then clip the artery, then cut the artery"
UP = "move right arm higher"


def line(
    folder: Path, said: Mapping[int, str], told: Mapping[int, int], means: str | None, obeyed: bool
) -> AuditLine:
    """Return what is found of the first saying; texts and numbers of orders that end by steps."""
    sayings = tuple(Saying(time_s=step / 30, text=text, means=means) for step, text in said.items())
    condition = replace(SUITES["nominal"].conditions[0], said=sayings)
    case = Case(arm=FIRST, suite="nominal", condition=condition, seed=1)
    rng = np.random.default_rng(0)
    with Recorder(config=case.config, path=folder / case.recording) as recorder:
        for step in range(40):
            answers = (answer(said[step], obeyed),) if step in said else ()
            remarks = ("Done: that.",) * told.get(step, 0) or ("The right arm stays there.",)
            recorder.on_step(random_step(rng, step, heard=answers, told=remarks))
    return audit(folder, [case])[0]


def test_what_is_said_after_the_end_is_not_heard(tmp_path: Path) -> None:
    found = line(tmp_path, {90: UP}, {}, UP, obeyed=True)
    assert (found.heard, found.right, found.ordered, found.reply) == (0, 0, 0, "")


def answer(text: str, obeyed: bool) -> Heard:
    instruction = Instruction(task=TASKS[1], source="human") if obeyed else None
    return Heard(time_s=0.0, reading=read(text), instruction=instruction, reply="re")


@pytest.mark.parametrize(
    ("told", "settled"),
    [({}, 0), ({9: 1}, 1), ({9: 1, 12: 2}, 3), ({9: 2, 31: 1}, 2), ({9: 5}, 3), ({2: 3}, 0)],
)
def test_an_order_is_settled_by_a_remark_before_something_else_is_said(
    tmp_path: Path, told: dict[int, int], settled: int
) -> None:
    found = line(tmp_path, {5: THREE, 30: UP}, told, "clip artery", obeyed=True)
    assert (found.ordered, found.settled) == (3, settled)


def test_an_order_that_was_refused_or_a_hold_is_no_order(tmp_path: Path) -> None:
    for text, obeyed in ((THREE, False), ("stop", True), ("resume", True)):
        found = line(tmp_path, {5: text}, {9: 1}, None, obeyed)
        assert (found.ordered, found.settled) == (0, 0)


@pytest.mark.parametrize(
    ("means", "obeyed", "right"),
    [(UP, True, 1), (UP, False, 0), (None, False, 1), (None, True, 0), ("stop", True, 0)],
)
def test_right_is_what_is_obeyed_as_meant_and_nothing_else(
    tmp_path: Path, means: str | None, obeyed: bool, right: int
) -> None:
    found = line(tmp_path, {5: UP}, {}, means, obeyed)
    assert (found.heard, found.right) == (1, right)


def test_a_condition_in_which_nobody_speaks_has_no_lines(tmp_path: Path) -> None:
    silent = Case(
        arm=FIRST, suite="nominal", condition=Condition(name="n", scenario="nominal"), seed=1
    )
    assert audit(tmp_path, [silent]) == ()
