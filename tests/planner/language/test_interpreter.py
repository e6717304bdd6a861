"""Tests of free text: clear sentences are understood, and unclear ones move nothing."""

from time import thread_time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.command import COMMANDS
from planner.correction import OPPOSITE
from planner.language import sentence_encoder
from planner.language.grammar import may_be_filled, parse
from planner.language.interpreter import Interpreter
from planner.language.slots import candidates
from tests.planner.language.sayings import ARMS, OPPOSITES, mirrored, moves, orders, tasks

INTERPRETER = Interpreter()


def command_text(sentence):
    command = INTERPRETER.read(sentence).command
    return command.text if command else None


@pytest.mark.parametrize("text", COMMANDS)
def test_a_command_reads_as_itself(text):
    reading = INTERPRETER.read(text)
    assert (reading.command, reading.by) == (COMMANDS[text], "grammar")
    assert text in reading.reply


@given(orders)
def test_every_order_and_its_mirror_image_are_understood(sentence):
    text = command_text(sentence)
    assert text is not None
    assert command_text(mirrored(sentence)) == mirrored(text)


@given(tasks, st.sampled_from(["left", "right"]))
def test_a_structure_means_the_tube_that_it_is_in_this_patient(sentence, duct):
    artery = {"left": "right", "right": "left"}[duct]
    of_structure = sentence.replace(f"{duct} tube", "duct").replace(f"{artery} tube", "artery")
    said = INTERPRETER.read(of_structure).command
    assert said is not None
    assert said.seen(duct) == INTERPRETER.read(sentence).command


@given(
    orders,
    st.sampled_from(["please {}", "could you {}?", "ok, {}", "{}, please", "{} now!", "Um {}"]),
)
def test_how_it_is_said_does_not_matter(sentence, frame):
    assert command_text(frame.format(sentence).upper()) == command_text(sentence)


@given(orders, st.sampled_from(["go on and {}", "carry on and {}", "again, {}", "{} again"]))
def test_an_order_with_again_or_go_on_is_that_order(sentence, frame):
    """Check that it means neither "resume" nor "repeat the last instruction"."""
    assert command_text(frame.format(sentence)) == command_text(sentence)


@pytest.mark.parametrize(
    ("sentence", "text"),
    [
        ("same on the left tube with the second clip", "clipping second clip left tube"),
        ("second clip, same tube on the right", "clipping second clip right tube"),
        ("kindly undo the same", "undo"),
        ("the same", "repeat"),
    ],
)
def test_the_same_repeats_only_where_nothing_else_is_named(sentence, text):
    assert command_text(sentence) == text


@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize(("one", "other"), OPPOSITES.items())
def test_too_far_one_way_means_the_other_way(arm, one, other):
    too_far = f"the {arm} is too far {one}" if "left" in one else f"{arm} too {one}"
    assert command_text(too_far) == command_text(f"move the {arm} {other}")


@pytest.mark.parametrize(("jaw", "said"), [("open", "open"), ("close", "tight")])
def test_too_open_means_close(jaw, said):
    assert command_text(f"left gripper is too {said}") == f"{OPPOSITE[jaw]} left gripper"


@pytest.mark.parametrize(
    ("sentence", "text"),
    [
        ("lower the left arm, it's too high", "move left arm lower"),
        ("open the left gripper too", "open left gripper"),
        ("the left arm is too close to me", "move left arm away from me"),
        ("the right arm isn't high enough", "move right arm higher"),
    ],
)
def test_too_turns_what_follows_only(sentence, text):
    assert command_text(sentence) == text


@given(
    orders,
    st.sampled_from(
        ["don't {}", "do not {}", "never {}", "please don't {}", "no, don't {}", "{}? No",
         "you must not {}", "why did you {}", "should we {}?", "is it time to {}", "{}?",
         "if it bleeds {}", "the nurse will {}", "I would {}", "when I say so {}", "he said {}"]
    ),
)  # fmt: skip
def test_denials_questions_suppositions_and_reports_move_nothing(sentence, frame):
    reading = INTERPRETER.read(frame.format(sentence))
    assert reading.command is None
    assert reading.reply.startswith("Not understood: it")


@given(
    orders,
    st.sampled_from(
        ["{} if you don't mind", "when you're ready, {}", "good. {}", "{} so I can see better",
         "would you be so kind as to {}", "{}, mate", "no, {}", "I want you to {}"]
    ),
)  # fmt: skip
def test_politeness_praise_and_reasons_change_nothing(sentence, frame):
    assert command_text(frame.format(sentence)) == command_text(sentence)


@pytest.mark.parametrize(
    ("sentence", "text"),
    [
        ("I'd like the left gripper opened", "open left gripper"),
        ("the left arm needs raising", "move left arm higher"),
        ("the duct can be divided now", "cut duct"),
        ("the robot opened the left gripper", None),
        ("the duct is divided", None),
        ("the left tube should be clipped by now", None),
        ("the left tube was cut too close to the clip", None),
        ("you could have cut the artery", None),
    ],
)
def test_a_wish_is_an_order_and_a_report_is_not(sentence, text):
    assert command_text(sentence) == text


@pytest.mark.parametrize(
    ("told", "text"),
    [
        ("the second clip is on the left tube", "going back second clip left tube"),
        ("the left tube has been cut", "go back from the cut left tube"),
    ],
)
def test_a_report_of_a_done_task_says_where_to_go_back_from(told, text):
    assert command_text(f"{told}, retreat") == text
    assert command_text(told) is None


@pytest.mark.parametrize(
    ("sentence", "text"),
    [
        ("left arm up", "move left arm higher"),
        ("left gripper, open it up", "open left gripper"),
        ("left arm in", "move left arm away from me"),
        ("a clip in, on the left tube", "clip left tube"),
    ],
)
def test_up_and_in_are_directions_of_motions_only(sentence, text):
    assert command_text(sentence) == text


@pytest.mark.parametrize(
    "sentence",
    ["put a fourth clip on the left tube", "clip the third tube on the left", "cut the middle tube",
     "clip the duct twice", "move the third arm higher"],
)  # fmt: skip
def test_an_unknown_thing_is_not_taken_for_a_known_one(sentence):
    assert command_text(sentence) is None


@given(moves, moves)
def test_two_orders_that_differ_are_asked_back(one, other):
    both = {command_text(one), command_text(other)}
    if len(both) == 2:
        assert command_text(f"{one} and {other}") is None


def test_an_unclear_sentence_is_asked_back_with_the_possible_meanings():
    reading = INTERPRETER.read("move to the left")
    assert reading.command is None
    assert {guess.text for guess in reading.guesses} == {
        "move left arm to the left",
        "move right arm to the left",
    }
    assert all(guess.text in reading.reply for guess in reading.guesses)


def test_warming_up_loads_what_unlisted_words_need():
    reader = Interpreter()
    reader.warm_up()
    assert "_heads" in vars(reader)
    assert sentence_encoder._weights.cache_info().currsize


def test_an_unlisted_word_is_understood_from_the_others():
    reading = INTERPRETER.read("jiggle the left arm higher")
    assert (reading.command, reading.by) == (COMMANDS["move left arm higher"], "classifier")


@pytest.mark.parametrize(
    "sentence", ["zap the duct", "zap the second clip on the left tube", "zap the arm higher"]
)
def test_a_side_a_clip_and_a_cut_are_never_guessed(sentence):
    parsed = parse(sentence)
    guessed = [c.text for c in candidates(parsed.filled) if may_be_filled(parsed, c)]
    assert not [text for text in guessed if text.startswith(("move", "clip", "cut"))]


@given(st.text() | st.text("abc lefrightclpduo?!,.'\n\t"))
def test_any_text_has_a_reading_and_a_reply_of_one_printable_line(text):
    reading = INTERPRETER.read(text)
    assert reading.text == text
    assert reading.reply
    assert reading.reply.isprintable()
    assert (reading.command is None) == (reading.by == "nobody")
    assert not (reading.command and reading.guesses)
    assert 0.0 <= reading.confidence <= 1.0


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "nothing was said"),
        ("  \n", "nothing was said"),
        ("clip the duct " * 8_000, "longer than 200 characters"),
        ("clip the\x00 duct", "cannot be read"),
        ("clip\x1b[31m the duct", "cannot be read"),
        ("clip the \ud800duct", "cannot be read"),
        ("クリップ the duct", "not in English"),
        ("осторожно clip the duct", "not in English"),
        ("mueve left arm to the izquierda", "not in English"),
        ("clip el duct por favor", "not in English"),
    ],
)
def test_unreadable_text_is_answered_at_once_and_moves_nothing(text, why):
    start_s = thread_time()
    reading = INTERPRETER.read(text)
    assert thread_time() - start_s < 0.05
    assert reading.command is None
    assert why in reading.reply


@pytest.mark.parametrize(
    "sentence",
    ["stop", "STOP!", "stop, you are too deep", "no, stop!", "everybody freeze", "don't move",
     "stop moving the left arm up"],
)  # fmt: skip
def test_stop_overrules_all_other_words(sentence):
    assert command_text(sentence) == "stop"


def test_only_stop_and_pause_keep_the_robot_still():
    assert {text for text, command in COMMANDS.items() if not command.moves} == {"stop", "pause"}
