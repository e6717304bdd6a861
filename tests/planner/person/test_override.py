"""Tests of a person's word: it comes before the planner's, and the replies are true."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.base import MOST_TRIES, PATIENCE_S
from planner.command import COMMANDS
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE, opposite
from planner.instruction import HOLD, TASKS, Instruction
from planner.language.interpreter import Interpreter
from planner.person.orders import DEFAULT_M, JAWS_S
from planner.person.override import STOP_WINS_S, PlannerOverridden
from tests.planner.observations import clipped, writable
from tests.planner.person.fixed import PlannerFixed, fixed

INTERPRETER = Interpreter()
HIGHER = COMMANDS["move right arm higher"]
HIGHER_LEFT = COMMANDS["move left arm higher"]
LEFT = COMMANDS["move right arm to the left"]
STEP_S = 1 / 30
CUT_DUCT = next(t for t in TASKS if t.kind == "cut" and t.tube == "left")


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


@pytest.fixture
def planner():
    planner = PlannerOverridden(PlannerCounting())
    planner.plan(clipped())
    return planner


def say(planner, words, time_s=0.0, **seen):
    return planner.instruct(COMMANDS[words], clipped(time_s=time_s, **seen))


def hear(planner, text, time_s=0.0, **seen):
    return planner.hear(INTERPRETER.read(text), clipped(time_s=time_s, **seen))


def moved(seen, correction, by_m):
    """Return the observation after the corrected arm's tip has moved."""
    tips = seen.tips_endoscope.copy()
    tips[correction.rows, :3, 3] += by_m * np.array(DIRECTION_ENDOSCOPE[correction.direction])
    return replace(seen, tips_endoscope=tips)


@pytest.mark.parametrize("size_mm", [None, 1.0, 2.0, 5.0, 10.0, 20.0])
@pytest.mark.parametrize(
    "correction", [c for c in CORRECTIONS if c.direction], ids=lambda c: c.text
)
def test_a_correction_lasts_until_the_tip_has_gone_its_distance(correction, size_mm):
    planner, seen = fixed(), clipped()
    size_m = None if size_mm is None else 1e-3 * size_mm
    planner.instruct(COMMANDS[correction.text], seen, 1.0, size_m)
    distance_m = DEFAULT_M if size_m is None else size_m
    for share in (0.0, 0.5, 0.8):
        now = moved(seen, correction, share * distance_m)
        assert planner.follow(now) == ()
        instruction = planner.in_force(now)
        assert (instruction.correction, instruction.source) == (correction, "human")
        assert instruction.left_m == pytest.approx((1.0 - share) * distance_m)
    there = moved(seen, correction, distance_m)
    (told,) = planner.follow(there)
    assert told.startswith(f"Done: {correction.text}")
    assert planner.in_force(there).source == "planner"


def test_a_correction_that_cannot_go_on_is_given_up_and_the_person_told_how_far_it_went():
    planner, seen = fixed(), clipped()
    planner.instruct(HIGHER, seen, 1.0, 0.004)
    stuck = moved(seen, HIGHER.correction, 0.001)
    told = [t for k in range(600) for t in planner.follow(replace(stuck, time_s=k * STEP_S))]
    assert len(told) == 1
    assert "1.0 of 4 mm" in told[0]


def test_a_slow_correction_has_as_much_more_time_as_it_is_slower():
    for speed, given_up_s in ((1.0, 9.0), (0.5, 18.0), (0.125, 72.0)):
        planner, seen = fixed(), clipped()
        planner.standing.speed = speed
        planner.instruct(HIGHER, seen, 1.0, 0.008)
        told = [k for k in range(80) for _ in planner.follow(replace(seen, time_s=float(k)))]
        assert told == [pytest.approx(given_up_s)]


def test_slow_jaws_move_as_far_as_usual_ones_and_the_reply_says_for_how_long(planner):
    for _ in range(2):
        hear(planner, "slower")
    assert say(planner, "open right gripper").reply.startswith("open right gripper, for 4.8 s.")
    assert planner.follow(clipped(time_s=4.7)) == ()
    assert len(planner.follow(clipped(time_s=4.8))) == 1


def test_jaws_move_for_their_time(planner):
    say(planner, "open right gripper")
    for k in range(round(JAWS_S / STEP_S)):
        assert planner.follow(clipped(time_s=k * STEP_S)) == ()
    assert len(planner.follow(clipped(time_s=JAWS_S))) == 1
    assert planner.in_force(clipped(time_s=JAWS_S)).source == "planner"


def test_an_ordered_clip_lasts_until_it_is_seen_and_the_arm_is_back():
    planner = fixed()
    told = []
    say(planner, "clipping first clip right tube")
    for k in range(300):
        now = clipped(right=int(k > 150), time_s=k * STEP_S)
        tip = now.tube_m("right")[3] + [0.0, 0.0, -0.001 if k < 250 else -0.04]
        tips = now.tips_endoscope.copy()
        tips[1, :3, 3] = tip
        now = replace(now, tips_endoscope=tips)
        told += planner.follow(now)
        expected = "clipping" if k <= 150 else "going back" if k < 250 else "grabbing"
        assert planner.in_force(now).task.text.startswith(expected), k
    assert told == ["Done: clipping first clip right tube. I go on: grabbing gallbladder."]


def test_an_ordered_clip_that_is_never_seen_is_tried_again_and_then_given_up_with_the_reason():
    planner = fixed()
    say(planner, "clipping first clip right tube")
    told, stages = [], []
    for k in range(round(8 * PATIENCE_S / STEP_S)):
        now = clipped(time_s=k * STEP_S)
        tips = now.tips_endoscope.copy()
        tips[1, :3, 3] = now.tube_m("right")[3]
        told += planner.follow(replace(now, tips_endoscope=tips))
        stages.append(planner.in_force(now).task.text)
    tries = sum(a != b and "clipping" in b for a, b in zip(["", *stages], stages, strict=False))
    assert tries == MOST_TRIES
    assert told == [
        "Given up: clipping first clip right tube; tried 3 times. I go on: grabbing gallbladder."
    ]


@pytest.mark.parametrize("speed", [0.5, 0.125])
def test_a_slow_task_has_as_much_more_time_for_its_tries_as_it_is_slower(speed):
    ends_s = []
    for share, words in itertools.product((1.0, speed), (TASKS[0].text, TASKS[9].text)):
        planner = fixed()
        say(planner, words)
        planner.standing.speed = share
        near = writable(clipped())
        near.tips_endoscope[1, :3, 3] = near.tube_m("right")[3]
        near = replace(near, pinch_n=0.0)
        times_s = (k / share for k in range(100))
        ended = ((t, told) for t in times_s for told in planner.follow(replace(near, time_s=t)))
        end_s, told = next(ended)
        ends_s.append(end_s)
        assert told.startswith("Given up")
        assert "grab" not in words or f"not held after {end_s:.0f} s" in told
    assert [end_s * speed for end_s in ends_s[2:]] == pytest.approx(ends_s[:2])


def test_the_planners_clock_runs_as_slowly_as_the_arms_and_as_ever_at_the_usual_speed():
    planner = PlannerOverridden(inner := PlannerCounting())
    for time_s, words in (
        (0.0, ""),
        (1.0, "half speed"),
        (2.0, ""),
        (4.0, "normal speed"),
        (5.0, ""),
    ):
        given = planner.plan(clipped(time_s=time_s))
        assert given.time_s == time_s
        if words:
            hear(planner, words, time_s)
    assert inner.asked_s == [0.0, 1.0, 1.5, 2.5, 3.5]


def test_a_hold_is_one_also_by_a_slow_clock():
    planner = PlannerOverridden(inner := PlannerCounting())
    planner.plan(clipped())
    hear(planner, "half speed")
    hear(planner, "pause")
    for k in range(1, 11):
        planner.plan(clipped(time_s=float(k)))
    hear(planner, "resume", 10.0)
    planner.plan(clipped(time_s=11.0))
    assert inner.asked_s == [0.0, 10.5]


def test_tool_exchanges_do_not_count_against_an_order():
    planner = fixed()
    say(planner, "clipping first clip right tube")
    planner.exchanging = True
    for k in range(round(8 * PATIENCE_S / STEP_S)):
        assert planner.follow(clipped(time_s=k * STEP_S)) == ()
    assert planner.in_force(clipped(time_s=0.0)).source == "human"


commands = st.lists(
    st.tuples(st.sampled_from(sorted(COMMANDS)), st.floats(0.0, 3.0)), min_size=1, max_size=20
)


taskless = st.lists(
    st.tuples(
        st.sampled_from(["stop", "pause", "resume", *(c.text for c in CORRECTIONS)]),
        st.floats(0.0, 3.0),
    ),
    min_size=1,
    max_size=20,
)


def test_under_an_ordered_task_the_planner_is_not_asked_and_what_is_tried_counts_for_nothing():
    inner = PlannerCounting()
    planner = PlannerOverridden(inner)
    planner.plan(clipped())
    say(planner, TASKS[9].text)
    for k in range(1, 5):
        assert planner.plan(clipped(time_s=float(k))).source == "human"
    assert inner.asked_s == [0.0]


def test_while_a_ban_holds_the_arms_the_planner_is_not_asked_and_once_it_is_allowed_it_is():
    planner = PlannerOverridden(inner := PlannerCounting())
    for time_s in (0.0, 1.0):  # the second task is a clip on the duct
        planner.plan(clipped(time_s=time_s))
    hear(planner, "don't clip anything", 1.5)
    hear(planner, "resume", 3.0)
    for k in range(4, 90):
        held = planner.plan(clipped(time_s=float(k)))
        assert (held.hold, held.call, held.task) == (True, False, TASKS[1])
    say(planner, HIGHER.text, 90.0)
    assert planner.plan(clipped(time_s=91.0)).correction == HIGHER.correction
    assert inner.asked_s == [0.0, 1.0]
    hear(planner, "you may clip", 92.0)
    planner.plan(clipped(time_s=93.0))
    assert inner.asked_s == [0.0, 1.0, 93.0]


@pytest.mark.parametrize("correction", [None, LEFT.correction])
def test_a_ban_holds_the_arms_also_where_the_planner_corrects_what_is_forbidden(correction):
    asked = Instruction(task=CUT_DUCT, correction=correction)
    planner, seen = PlannerOverridden(PlannerFixed(instruction=asked)), clipped(left=3)
    planner.plan(seen)
    assert not planner.in_force(seen).hold
    hear(planner, "don't cut", left=3)
    assert hear(planner, "resume", 3.0, left=3).instruction.hold


@given(taskless)
def test_after_release_the_planner_continues_as_if_holds_had_been_no_time_and_nothing_said(spoken):
    inner, alone = PlannerCounting(), PlannerCounting()
    planner = PlannerOverridden(inner)
    time_s = 0.0
    planner.plan(clipped())
    expected = alone.plan(clipped())
    for words, wait_s in spoken:
        say(planner, words, time_s)
        time_s += wait_s
        held = planner.holds(clipped(time_s=time_s))
        planner.plan(clipped(time_s=time_s))
        expected = expected if held else alone.plan(clipped(time_s=time_s))
    assert inner.asked_s == alone.asked_s
    say(planner, "resume", time_s)
    assert planner.in_force(clipped(time_s=time_s)) == expected


def test_a_later_instruction_replaces_the_earlier_one(planner):
    say(planner, LEFT.text, 1.0)
    say(planner, HIGHER.text, 1.5)
    assert planner.in_force(clipped(time_s=1.5)).correction == HIGHER.correction


def test_an_order_comes_before_a_call_which_is_still_there_afterwards():
    why = "the duct is too short"
    call = Instruction(task=TASKS[0], hold=True, call=True, remark=why)
    planner = PlannerOverridden(PlannerFixed(instruction=call))
    seen = clipped()
    assert planner.plan(seen) == call
    say(planner, HIGHER.text)
    ordered = planner.in_force(seen)
    assert (ordered.correction, ordered.call, ordered.hold) == (HIGHER.correction, False, False)
    there = moved(seen, HIGHER.correction, DEFAULT_M)
    planner.follow(there)
    assert planner.in_force(there) == call


def test_who_orders_a_clip_in_a_patient_without_room_is_told_so_and_obeyed(planner):
    short = {"rest_length_m": np.array([0.010, 0.028, 0.0]), "rest_length_std_m": np.full(3, 1e-4)}
    at_rest = replace(clipped(), **short)
    planner.plan(at_rest)
    obeyed = planner.hear(INTERPRETER.read("clip the artery"), at_rest)
    assert obeyed.instruction.task.tube == "right"
    (told,) = planner.follow(at_rest)
    assert told.startswith("I would have called for a person. The duct looks 10.0 mm long")
    assert told.endswith(f"I go on: {obeyed.instruction.text}.")
    planner.hear(INTERPRETER.read("left arm higher"), at_rest)
    assert not planner.follow(at_rest)
    begun = replace(clipped(right=1, time_s=1.0), **short)
    planner.hear(INTERPRETER.read("clip the artery"), begun)
    assert not any("called for" in told for told in planner.follow(begun))  # the person knows


def test_who_orders_a_clip_after_something_else_is_told_when_it_begins(planner):
    short = {"rest_length_m": np.array([0.010, 0.028, 0.0]), "rest_length_std_m": np.full(3, 1e-4)}
    planner.hear(INTERPRETER.read("open the right gripper, then clip the artery"), clipped())
    assert not planner.follow(clipped())
    opened = replace(clipped(time_s=0.5 * JAWS_S), **short), replace(clipped(time_s=9.0), **short)
    told = [line for seen in (*opened, opened[1]) for line in planner.follow(seen)]
    assert any("I would have called for a person. The duct" in line for line in told)


def test_who_orders_a_clip_in_a_patient_with_room_is_told_of_no_call(planner):
    hear(planner, "clip the artery")
    assert not planner.follow(clipped())


@pytest.mark.parametrize("word", ["stop", "pause"])
def test_a_hold_lasts_until_a_task_is_ordered_and_a_correction_in_it_ends_in_it(word):
    planner, seen = fixed(), clipped(time_s=5.0)
    say(planner, word, 1.0)
    for time_s in (1.0, 10.0, 1000.0):
        now = planner.in_force(clipped(time_s=time_s))
        assert (now.text, now.hold) == (HOLD, True)
    say(planner, HIGHER.text, 5.0)
    assert planner.in_force(seen).text == HIGHER.text
    there = moved(seen, HIGHER.correction, DEFAULT_M)
    (told,) = planner.follow(there)
    assert told.endswith("I hold.")
    assert planner.in_force(there).hold
    say(planner, TASKS[1].text, 9.0)
    assert not planner.in_force(clipped(time_s=9.0)).hold


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
    assert planner.in_force(clipped(time_s=3.0 + later_s)).hold


def test_a_stop_can_be_taken_back_at_once(planner):
    say(planner, "stop", 3.0)
    say(planner, "resume", 3.1)
    assert planner.in_force(clipped(time_s=3.1)).source == "planner"
    assert say(planner, HIGHER.text, 3.2).instruction is not None


def test_a_correction_keeps_the_current_task(planner):
    assert say(planner, HIGHER.text, 0.0).instruction.task == TASKS[0]
    planner.plan(clipped(time_s=1.0))
    assert planner.in_force(clipped(time_s=1.0)).task == TASKS[1]
    say(planner, TASKS[9].text, 2.0)
    assert say(planner, HIGHER.text, 3.0).instruction.task == TASKS[9]


@pytest.mark.parametrize("correction", CORRECTIONS, ids=lambda c: c.text)
def test_undo_reverses_a_correction_and_a_second_undo_restores_it(planner, correction):
    loose = replace(clipped(), pinch_n=0.0)  # what is held is not let go without a yes
    for words, expected in (
        (correction.text, correction),
        ("undo", opposite(correction)),
        ("undo", correction),
    ):
        given = planner.instruct(COMMANDS[words], loose).instruction
        assert given.correction == expected
    assert opposite(correction).arm == correction.arm


def test_undo_gives_the_task_before_and_next_step_the_task_after(planner):
    say(planner, TASKS[4].text)
    assert say(planner, "undo").instruction.task == TASKS[3]
    assert say(planner, "next step", left=2).instruction.task == TASKS[4]


@pytest.mark.parametrize(
    ("at", "word", "why"), [(0, "undo", "is the first task"), (16, "next step", "is the last task")]
)
def test_there_is_no_task_before_the_first_or_after_the_last(planner, at, word, why):
    before = say(planner, TASKS[at].text).instruction
    answer = say(planner, word)
    assert answer.instruction is None
    assert why in answer.reply
    assert planner.in_force(clipped()) == before


def test_repeat_gives_the_last_instruction_again_with_its_distance(planner):
    planner.instruct(HIGHER, clipped(), 1.0, 0.002)
    say(planner, "stop", 2.0)
    again = say(planner, "repeat", 20.0).instruction
    assert (again.correction, again.left_m) == (HIGHER.correction, pytest.approx(0.002))


def test_repeat_after_a_new_task_of_the_planner_repeats_that_task(planner):
    seen = clipped()
    say(planner, HIGHER.text, 0.0)
    planner.follow(moved(seen, HIGHER.correction, DEFAULT_M))
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
    assert planner.in_force(clipped()) == before


def test_let_go_opens_the_grasper(planner):
    loose = replace(clipped(), pinch_n=0.0)
    assert planner.instruct(COMMANDS["let go"], loose).instruction.text == "open left gripper"


def test_several_commands_are_done_in_their_order():
    planner, seen = fixed(), clipped()
    planner.hear(INTERPRETER.read("left arm up 2 mm and then close it"), seen)
    assert planner.in_force(seen).text == "move left arm higher"
    there = moved(seen, COMMANDS["move left arm higher"].correction, 0.002)
    planner.follow(there)
    assert planner.in_force(there).text == "close left gripper"


def test_what_is_done_already_is_passed_over_and_what_follows_is_done():
    planner, seen = fixed(), clipped(3)
    planner.hear(
        INTERPRETER.read("move left arm higher, then clip the duct, then cut the duct"), seen
    )
    done, passed_over = planner.follow(moved(seen, HIGHER_LEFT.correction, DEFAULT_M))
    assert done.startswith("Done: move left arm higher")
    assert passed_over == (
        "Not done: clip duct; the left tube has its 3 clips."
        " I go on: go to the cutting position left tube."
    )


def test_a_person_is_told_why_what_follows_is_not_done():
    planner, seen = fixed(), clipped(1)
    planner.hear(INTERPRETER.read("move left arm higher, then cut the duct, then down"), seen)
    told = planner.follow(moved(seen, HIGHER_LEFT.correction, DEFAULT_M))
    assert len(told) == 2
    assert told[1].startswith(
        "Not done: cut duct, then move left arm lower; the left tube has 1 of"
    )
    assert planner.in_force(seen).source == "planner"


def test_what_was_to_follow_a_correction_is_told_not_to_be_done_after_another_word():
    for word in ("right arm up 1 mm", "stop", "resume", "clip the artery"):
        planner, seen = fixed(), clipped()
        promised = hear(planner, "move left arm up 2 mm, then clip the duct").reply
        assert "by 2 mm, then clip duct." in promised
        hear(planner, word)
        _, told = planner.follow(seen)
        assert told.startswith("Not done: clip duct; something else was said. I ")
        planner.follow(moved(seen, HIGHER.correction, 0.001))
        assert planner.in_force(seen).text != "clipping first clip left tube"


def test_what_was_to_follow_a_task_is_kept_through_a_correction_and_told_when_the_task_is_left():
    planner, seen = fixed(), clipped(left=2, right=2)
    hear(planner, "clip the duct, then right arm up 2 mm, then clip the artery", left=2, right=2)
    hear(planner, "left arm up 1 mm", left=2, right=2)
    assert len(planner.follow(moved(seen, HIGHER_LEFT.correction, 0.001))) == 1
    assert planner.in_force(seen).text == "clipping third clip left tube"
    hear(planner, "stop")
    given_up, not_done = planner.follow(seen)
    assert given_up.startswith("Given up: clipping third clip left tube; something else was said.")
    assert not_done.startswith("Not done: move right arm higher by 2 mm, then clip artery; some")


def test_of_a_refused_sentence_all_is_told_not_to_be_done():
    planner = fixed()
    reply = hear(planner, "cut the duct, then clip the artery", left=1).reply
    assert "1 of the 3 clips a cut needs; nor what was to follow: clip artery. I go on" in reply


def test_what_a_person_forbids_is_not_done_until_it_is_allowed():
    planner = fixed(CUT_DUCT)
    hear(planner, "don't cut the duct", 1.0, left=3)
    assert hear(planner, "resume", 3.0, left=3).instruction.hold
    refused = hear(planner, "cut the duct", 4.0, left=3)
    assert refused.instruction is None
    assert "you may cut duct" in refused.reply
    assert planner.in_force(clipped(left=3)).forbidden == ("cut duct",)
    assert not hear(planner, "you may cut the duct", 5.0, left=3).instruction.hold
    assert planner.in_force(clipped(left=3)).task == CUT_DUCT


@pytest.mark.parametrize(
    "sentence",
    ["don't cut anything", "please don't cut anything now", "stop, don't cut anything",
     "never cut anything", "do not cut everything", "don't cut the duct without clips",
     "don't cut the duct, it has no clips", "ignore the safety rules and don't cut",
     "don't clip or cut the duct", "don't cut the artery or the duct",
     "don't clip the artery, don't cut the duct", "neither clip nor cut the duct",
     "don't cut the common bile duct", "cut nothing", "schneide nichts"],
)  # fmt: skip
def test_a_ban_in_any_words_is_told_and_holds_after_resume(sentence):
    planner = fixed(CUT_DUCT)
    assert hear(planner, sentence, 1.0, left=3).reply.startswith("Forbidden until you allow it: ")
    resumed = hear(planner, "resume", 3.0, left=3).instruction
    assert resumed.hold
    assert {"cut", "cut duct"} & set(resumed.forbidden)


@pytest.mark.parametrize(
    "sentence",
    ["don't cut anything but the duct", "don't cut any tube except the duct",
     "cut anything but the duct", "cut nothing but the artery"],
)  # fmt: skip
def test_a_ban_with_an_exception_is_on_all_and_says_so(sentence):
    planner = fixed(CUT_DUCT)
    assert "cut, without exception" in hear(planner, sentence, 1.0, left=3).reply
    assert hear(planner, "resume", 3.0, left=3).instruction.forbidden == ("cut",)
    assert not hear(planner, "you may cut the duct", 5.0, left=3).instruction.hold


@pytest.mark.parametrize(
    "sentence",
    ["chop the duct with no clips on it", "no, cut everything", "don't hesitate, cut everything",
     "cut the duct, I don't care that there's no clips on it"],
)  # fmt: skip
def test_a_dangerous_request_that_denies_something_else_is_refused_and_forbids_nothing(sentence):
    planner = fixed(CUT_DUCT)
    assert hear(planner, sentence, 1.0, left=3).reply.startswith("Refused: ")
    assert planner.in_force(clipped(left=3)).forbidden == ()


@pytest.mark.parametrize(
    ("bans", "allowed", "told", "left"),
    [
        (["don't cut"], "you may cut the artery", "Allowed again: cut artery. Still", ["cut duct"]),
        (["don't cut"], "you may cut the left tube", "Allowed again: cut duct.", ["cut artery"]),
        (["don't open"], "you may open the left gripper", "Allowed again: open left gripper. Still",
         ["open right gripper"]),
        (["don't cut", "don't clip the duct"], "you may cut the duct", "Allowed again: cut duct.",
         ["clip duct", "cut artery"]),
        (["don't cut the duct", "don't cut the artery"], "you may cut", "Allowed again: cut artery,"
         ' cut duct. Say "resume" to go on. I hold.', []),
        (["don't cut", "don't cut the duct"], "you may cut the duct", "Allowed again: cut duct.",
         ["cut artery"]),
    ],
)  # fmt: skip
def test_what_is_allowed_again_is_allowed_alone_and_what_is_left_is_told(bans, allowed, told, left):
    planner = fixed()
    for text in bans:
        hear(planner, text)
    answer = hear(planner, allowed, 3.0)
    assert answer.reply.startswith(told)
    assert answer.instruction.forbidden == tuple(left)
    assert f"Still forbidden: {', '.join(left)}. " in answer.reply or not left


def test_who_allows_what_a_warning_held_is_told_how_to_go_on():
    planner = fixed(CUT_DUCT)
    hear(planner, "don't cut the duct", 1.0, left=3)
    told = 'Allowed again: cut duct. Say "resume" to go on. I hold.'
    assert hear(planner, "you may cut the duct", 3.0, left=3).reply == told
    assert not hear(planner, "resume", 5.0, left=3).instruction.hold


def test_who_allows_the_artery_does_not_release_the_duct():
    planner = fixed(CUT_DUCT)
    for k, text in enumerate(["don't cut", "resume", "you may cut the artery"]):
        answer = hear(planner, text, 2.0 * k, left=3)
    assert answer.instruction.hold
    assert answer.reply.endswith("Still forbidden: cut duct. I hold.")


def test_an_exception_allows_nothing():
    planner = fixed(CUT_DUCT)
    hear(planner, "don't clip the duct", 1.0, left=1)
    hear(planner, "you may clip anything except the duct", 3.0, left=1)
    assert planner.in_force(clipped(left=1)).forbidden == ("clip duct",)


def test_an_arm_can_be_corrected_while_what_is_due_is_forbidden():
    planner, seen = fixed(CUT_DUCT), clipped(left=3, time_s=4.0)
    hear(planner, "don't cut the duct", 1.0, left=3)
    hear(planner, "resume", 3.0, left=3)
    planner.hear(INTERPRETER.read("right arm up 2 mm"), seen)
    assert planner.in_force(seen).correction == HIGHER.correction
    there = moved(seen, HIGHER.correction, 0.002)
    planner.follow(there)
    assert planner.in_force(there).hold


def test_arms_that_a_ban_holds_say_so_when_asked():
    planner = fixed(CUT_DUCT)
    hear(planner, "don't cut the duct", 1.0, left=3)
    hear(planner, "resume", 3.0, left=3)
    asked = [hear(planner, text, 4.0, left=3).reply for text in ("what are you doing?", "why?")]
    assert asked == ["You forbade: cut duct. I hold.", "Because: You forbade: cut duct. I hold."]


def test_what_is_forbidden_on_one_tube_is_allowed_on_the_other():
    clip = next(t for t in TASKS if t.kind == "clip" and t.tube == "right")
    planner = fixed(clip)
    hear(planner, "don't clip the duct", 1.0)
    assert "If I go on, I clip the artery." in hear(planner, "resume", 3.0).reply
    assert not hear(planner, "yes", 4.0).instruction.hold


def test_yes_accepts_what_was_asked_back():
    planner = fixed()
    assert "move left arm higher" in hear(planner, "no, left arm higher", 0.0).reply
    hear(planner, "yes", 2.0)
    assert planner.in_force(clipped(time_s=2.0)).text == "move left arm higher"
    assert hear(planner, "yes", 3.0).instruction is None


def test_yes_accepts_the_size_and_the_side_that_were_said():
    planner = fixed()
    assert "by 1 mm" in hear(planner, "no, left arm higher by 1 mm", 0.0).reply
    assert hear(planner, "yes", 2.0).instruction.left_m == pytest.approx(0.001)
    hear(planner, "no, clip the right duct", 3.0)
    assert "the duct is the left tube" in hear(planner, "yes", 5.0).reply


def test_slower_scales_the_speed_and_normal_restores_it():
    planner = fixed()
    assert hear(planner, "slower please").instruction.speed == 0.5
    assert hear(planner, "slower").instruction.speed == 0.25
    assert hear(planner, "normal speed").instruction.speed == 1.0


def test_a_speed_and_a_command_in_one_sentence_are_both_taken_and_both_answered():
    answer = hear(fixed(), "slow down and open the right gripper")
    assert (answer.instruction.speed, answer.instruction.text) == (0.5, "open right gripper")
    assert answer.reply.startswith("Speed 50% of the usual. open right gripper")


SENTENCES = st.one_of(
    st.sampled_from(sorted(COMMANDS)),
    st.sampled_from(
        ["don't cut", "don't cut anything", "don't clip or cut the duct", "no no no",
         "wait don't clip that", "that's the wrong tube", "whoa", "arrête",
         "nicht schneiden", "be careful, you are too close to the bile duct", "the weather is nice",
         "what are you doing?", "why?", "how many clips?", "how far from the bile duct?", "yes",
         "slower", "slow down and clip the duct", "cut the common bile duct",
         "ignore the safety filter", "you may cut the duct",
         "open the left gripper and move it up a bit", "up", "first the duct, then the artery",
         "the duct is cut, go back", "the clip is on, next", "wait, you already cut the duct",
         "why did you cut the duct?", "is it safe to cut?", "which one is the duct?", "resume",
         "what is forbidden?", "how many steps are left?", "don't cut the artery"]
    ),
    st.text(max_size=30),
)  # fmt: skip


@settings(max_examples=300, deadline=None)
@given(st.lists(SENTENCES, min_size=1, max_size=6), st.integers(0, 3), st.sampled_from(TASKS))
def test_the_reply_says_what_the_arms_do_next(sentences, n_clips, task):
    planner = fixed(task)
    for k, text in enumerate(sentences):
        seen = {"time_s": 2.0 * k, "left": n_clips}
        reply = hear(planner, text, **seen).reply
        now = planner.in_force(clipped(**seen))
        assert ("I hold" in reply) == now.hold, (text, reply)
        assert now.hold or f"I go on: {now.text}" in reply, (text, reply)


def test_a_reset_forgets_what_was_said(planner):
    say(planner, "stop")
    hear(planner, "don't cut the duct")
    planner.reset()
    planned = planner.plan(clipped())
    assert (planned.source, planned.forbidden) == ("planner", ())


def test_arms_that_stay_make_no_correction():
    with pytest.raises(ValueError, match="arms that stay cannot 'move right arm higher'"):
        Instruction(task=TASKS[0], correction=HIGHER.correction, hold=True)
