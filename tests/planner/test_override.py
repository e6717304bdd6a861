"""Tests of the override: a person comes first for a time; the planner goes on unaffected."""

from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.command import COMMANDS
from planner.correction import CORRECTIONS, opposite
from planner.instruction import HOLD, TASKS, Instruction
from planner.override import HOLD_S, STOP_WINS_S, PlannerOverridden
from tests.planner.seen import clipped
from tissue_sim.periods import CONTROL_PERIOD_S

HIGHER = COMMANDS["move right arm higher"]
LEFT = COMMANDS["move right arm to the left"]


class PlannerCounting:
    """Answers with the next task each time it is called, from the first on; the last one stays."""

    def __init__(self):
        self.asked_s = []

    def reset(self):
        self.asked_s = []

    hears_of_success = False

    def plan(self, observation):
        self.asked_s.append(observation.time_s)
        task = TASKS[min(len(self.asked_s), len(TASKS)) - 1]
        return Instruction(task=task, time_s=observation.time_s)


@dataclass(frozen=True, kw_only=True)
class PlannerFixed:
    instruction: Instruction
    hears_of_success: bool = False

    def reset(self):
        pass

    def plan(self, observation):
        return self.instruction


@pytest.fixture
def planner():
    planner = PlannerOverridden(PlannerCounting())
    planner.plan(clipped())
    return planner


def say(planner, words, time_s=0.0, **seen):
    return planner.instruct(COMMANDS[words], clipped(time_s=time_s, **seen))


def test_a_persons_instruction_comes_first_for_5_seconds_and_no_step_longer(planner):
    given_s = 7.0
    before = planner.in_force(given_s)
    say(planner, HIGHER.text, given_s)
    lasting = round(HOLD_S / CONTROL_PERIOD_S)
    said = [planner.in_force(given_s + k * CONTROL_PERIOD_S) for k in range(lasting + 30)]
    assert [s.source for s in said] == ["human"] * lasting + ["planner"] * 30
    assert {s.correction for s in said[:lasting]} == {HIGHER.correction}
    assert {s.time_s for s in said[:lasting]} == {given_s}
    assert said[-1] == before


commands = st.lists(
    st.tuples(st.sampled_from(sorted(COMMANDS)), st.floats(0.0, 3.0)), min_size=1, max_size=20
)


@given(commands)
def test_after_release_the_planner_continues_as_if_holds_had_been_no_time_and_nothing_said(spoken):
    inner, alone = PlannerCounting(), PlannerCounting()
    planner = PlannerOverridden(inner)
    time_s = 0.0
    planner.plan(clipped())
    expected = alone.plan(clipped())
    for words, wait_s in spoken:
        say(planner, words, time_s)
        time_s += wait_s
        held = planner.in_force(time_s).hold
        planner.plan(clipped(time_s=time_s))
        expected = expected if held else alone.plan(clipped(time_s=time_s))
    assert inner.asked_s == alone.asked_s
    say(planner, "resume", time_s)
    assert planner.in_force(time_s) == expected


def test_a_later_instruction_replaces_the_earlier_one_for_its_own_5_seconds(planner):
    say(planner, LEFT.text, 1.0)
    say(planner, HIGHER.text, 1.5)
    assert planner.in_force(1.5).correction == HIGHER.correction
    assert planner.in_force(1.4 + HOLD_S).source == "human"
    assert planner.in_force(1.5 + HOLD_S).source == "planner"


def test_an_order_comes_before_a_call_which_is_still_there_afterwards():
    why = "the duct is too short"
    call = Instruction(task=TASKS[0], hold=True, call=True, remark=why)
    planner = PlannerOverridden(PlannerFixed(instruction=call))
    assert planner.plan(clipped()) == call
    say(planner, HIGHER.text, 1.0)
    ordered = planner.in_force(1.0)
    assert (ordered.correction, ordered.call, ordered.hold) == (HIGHER.correction, False, False)
    assert planner.in_force(1.0 + HOLD_S) == call


@pytest.mark.parametrize("word", ["stop", "pause"])
def test_a_stop_lasts_until_something_else_is_said(planner, word):
    say(planner, word, 1.0)
    for time_s in (1.0, 10.0, 1000.0):
        assert (planner.in_force(time_s).text, planner.in_force(time_s).hold) == (HOLD, True)
    say(planner, HIGHER.text, 1000.0)
    assert planner.in_force(1000.0).text == HIGHER.text
    assert planner.in_force(1000.0 + HOLD_S).source == "planner"


@given(commands, st.floats(0.0, 0.99 * STOP_WINS_S))
def test_a_stop_overrules_commands_in_the_same_second(spoken, later_s):
    planner = PlannerOverridden(PlannerCounting())
    planner.plan(clipped())
    for words, _ in spoken:
        say(planner, words, 3.0)
    say(planner, "stop", 3.0)
    for words, _ in spoken:
        if words != "resume":
            say(planner, words, 3.0 + later_s)
    assert planner.in_force(3.0 + later_s).hold


def test_a_stop_can_be_taken_back_at_once(planner):
    say(planner, "stop", 3.0)
    say(planner, "resume", 3.1)
    assert planner.in_force(3.1).source == "planner"
    assert say(planner, HIGHER.text, 3.2).instruction is not None


def test_a_correction_keeps_the_current_task(planner):
    assert say(planner, HIGHER.text, 0.0).instruction.task == TASKS[0]
    planner.plan(clipped(time_s=1.0))
    assert planner.in_force(1.0).task == TASKS[1]
    say(planner, TASKS[9].text, 2.0)
    assert say(planner, HIGHER.text, 3.0).instruction.task == TASKS[9]


@pytest.mark.parametrize("correction", CORRECTIONS, ids=lambda c: c.text)
def test_undo_reverses_a_correction_and_a_second_undo_restores_it(planner, correction):
    say(planner, correction.text, 0.0)
    assert say(planner, "undo", 1.0).instruction.correction == opposite(correction)
    assert say(planner, "undo", 2.0).instruction.correction == correction
    assert opposite(correction).arm == correction.arm


def test_undo_gives_the_task_before_and_next_step_the_task_after(planner):
    say(planner, TASKS[4].text)
    assert say(planner, "undo").instruction.task == TASKS[3]
    assert say(planner, "next step").instruction.task == TASKS[4]


@pytest.mark.parametrize(
    ("at", "word", "why"), [(0, "undo", "is the first task"), (16, "next step", "is the last task")]
)
def test_there_is_no_task_before_the_first_or_after_the_last(planner, at, word, why):
    before = say(planner, TASKS[at].text).instruction
    answer = say(planner, word)
    assert answer.instruction is None
    assert why in answer.reply
    assert planner.in_force(0.0) == before


def test_repeat_gives_the_last_instruction_for_another_5_seconds(planner):
    say(planner, HIGHER.text, 0.0)
    say(planner, "stop", 2.0)
    assert say(planner, "repeat", 20.0).instruction.correction == HIGHER.correction
    assert planner.in_force(19.9 + HOLD_S).source == "human"


def test_repeat_after_a_new_task_of_the_planner_repeats_that_task(planner):
    say(planner, HIGHER.text, 0.0)
    planner.plan(clipped(time_s=10.0))
    instruction = say(planner, "repeat", 11.0).instruction
    assert (instruction.task, instruction.correction) == (TASKS[1], None)


@pytest.mark.parametrize("duct", ["left", "right"])
def test_a_structure_means_the_tube_that_it_is_in_this_patient(duct):
    artery = "right" if duct == "left" else "left"
    planner = PlannerOverridden(PlannerCounting())
    planner.plan(clipped(duct=duct))
    for words, tube in (("duct", duct), ("artery", artery), (f"{duct} tube", duct)):
        seen = {duct: 1, artery: 2, "duct": duct}
        expected = {
            duct: f"clipping second clip {duct} tube",
            artery: f"clipping third clip {artery} tube",
        }
        assert say(planner, f"clip {words}", **seen).instruction.text == expected[tube]
    assert say(planner, "clipping first clip artery", duct=duct).instruction.text == (
        f"clipping first clip {artery} tube"
    )


def test_a_command_that_is_not_possible_is_refused_and_changes_nothing(planner):
    before = say(planner, HIGHER.text).instruction
    answer = say(planner, "cut left tube", left=2)
    assert answer.instruction is None
    assert "2 of the 3 clips" in answer.reply
    assert planner.in_force(0.0) == before


def test_let_go_opens_the_grasper(planner):
    assert say(planner, "let go").instruction.text == "open left gripper"


def test_a_reset_forgets_what_was_said(planner):
    say(planner, "stop")
    planner.reset()
    assert planner.plan(clipped()).source == "planner"


def test_arms_that_stay_make_no_correction():
    with pytest.raises(ValueError, match="arms that stay cannot 'move right arm higher'"):
        Instruction(task=TASKS[0], correction=HIGHER.correction, hold=True)
