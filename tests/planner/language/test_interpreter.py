"""Tests of free text: clear sentences are understood, and unclear ones move nothing."""

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from planner.command import COMMANDS
from planner.correction import OPPOSITE, opposite
from planner.language import sentence_encoder
from planner.language.grammar import may_be_filled, parse
from planner.language.interpreter import Interpreter
from planner.language.slots import candidates
from tests.planner.language.sayings import ARMS, OPPOSITES, deeds, mirrored, moves, orders, tasks

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
    assume("right now" not in frame.format(sentence))  # that is a time, and no direction
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
        ["why did you {}", "should we {}?", "is it time to {}", "{}?", "if I nod {}",
         "the nurse will {}", "I would {}", "when I say so {}", "he said {}"]
    ),
)  # fmt: skip
def test_questions_suppositions_and_reports_move_nothing(sentence, frame):
    reading = INTERPRETER.read(frame.format(sentence))
    if reading.command is not None:  # it sounds like doubt
        assert (reading.command.word, reading.by) == ("stop", "warning")
    else:
        assert reading.question or reading.reply.startswith("Not understood: it")


@given(
    orders,
    st.sampled_from(
        ["don't {}", "do not {}", "never {}", "please don't {}", "no, don't {}", "{}? No",
         "you must not {}", "no, {}", "wait, {}", "careful, {}", "wrong, {}", "whoa, {}",
         "if it bleeds {}", "nein, {}", "arrête, {}", "¡cuidado! {}", "attenzione, {}", "别 {}"]
    ),
)  # fmt: skip
def test_denials_alarms_and_doubts_hold_whatever_else_is_said(sentence, frame):
    reading = INTERPRETER.read(frame.format(sentence))
    assert reading.command is not None
    assert reading.command.word in ("stop", "pause")
    assert reading.then == ()


@given(deeds, st.sampled_from(["don't {}", "never {}", "whoa, do not {} yet"]))
def test_a_prohibition_names_the_act(sentence, frame):
    (forbidden,) = INTERPRETER.read(frame.format(sentence)).forbids
    assert forbidden.act == ("cut" if sentence.startswith(("cut", "divide")) else "clip")
    assert forbidden.on in sentence


def test_no_followed_by_an_order_forbids_nothing_and_asks_whether_that_is_meant():
    reading = INTERPRETER.read("no, clip the duct")
    assert reading.forbids == ()
    assert [guess.text for guess in reading.guesses] == ["clip duct"]


@given(
    orders,
    st.sampled_from(
        ["{} if you don't mind", "when you're ready, {}", "good. {}", "{} so I can see better",
         "would you be so kind as to {}", "{}, mate", "I want you to {}"]
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
        ("both clips are on", None),
        ("the left tube should be clipped by now", None),
        ("you could have cut the artery", "stop"),
    ],
)
def test_a_wish_is_an_order_and_a_report_is_none_or_a_doubt(sentence, text):
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
    assert command_text(told) in (None, "stop")


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
def test_two_motions_are_made_in_their_order_unless_the_second_undoes_the_first(one, other):
    first, second = (INTERPRETER.read(text).command for text in (one, other))
    reading = INTERPRETER.read(f"{one} and {other}")
    if first == second:
        assert (reading.command, reading.then) == (first, ())
    elif second.correction == opposite(first.correction):
        assert reading.command is None
    else:
        assert [reading.command, *(said.command for said in reading.then)] == [first, second]


@pytest.mark.parametrize(
    ("sentence", "said"),
    [
        ("open the left gripper and move it up a bit",
         [("open left gripper", None), ("move left arm higher", 1.5)]),
        ("right arm left 4 mm, down 1",
         [("move right arm to the left", 4.0), ("move right arm lower", 1.0)]),
        ("clip the duct, and after that clip the artery",
         [("clip duct", None), ("clip artery", None)]),
        ("second clip duct, come back, third clip duct",
         [("clipping second clip duct", None), ("going back second clip duct", None),
          ("clipping third clip duct", None)]),
        ("arms apart, two millimetres each",
         [("move left arm to the left", 2.0), ("move right arm to the right", 2.0)]),
        ("bring the arms together by 1 mm",
         [("move left arm to the right", 1.0), ("move right arm to the left", 1.0)]),
        ("take both arms down, left by 1 mm, right by 3 mm",
         [("move left arm lower", 1.0), ("move right arm lower", 3.0)]),
        ("left arm up 4 mm, right arm half of that",
         [("move left arm higher", 4.0), ("move right arm higher", 2.0)]),
        ("right arm up 2 mm, left likewise",
         [("move right arm higher", 2.0), ("move left arm higher", 2.0)]),
        ("grasper left 3 mm, scissors same again but to the right",
         [("move left arm to the left", 3.0), ("move right arm to the right", 3.0)]),
        ("grasper diagonally up and right, 2 mm each way",
         [("move left arm higher", 2.0), ("move left arm to the right", 2.0)]),
        ("clip the duct and afterwards the artery",
         [("clip duct", None), ("clip artery", None)]),
        ("come away from the second clip on the artery and proceed to place the third one",
         [("going back second clip artery", None), ("clipping third clip artery", None)]),
        ("next step, but first right arm towards me 4 mm",
         [("move right arm towards me", 4.0), ("next step", None)]),
        ("you clip the duct first, and afterwards the artery",
         [("clip duct", None), ("clip artery", None)]),
        ("put second clip in duct, go back from it after",
         [("clipping second clip duct", None), ("going back second clip duct", None)]),
        ("before to cut the artery you put the third clip on it",
         [("clipping third clip artery", None), ("cut artery", None)]),
        ("drop the grasper 2 mm, same arm 3 mm left",
         [("move left arm lower", 2.0), ("move left arm to the left", 3.0)]),
        ("clips one and two on the duct, in that order",
         [("clipping first clip duct", None), ("clipping second clip duct", None)]),
        ("1) open the left gripper 2) left arm up 3) close the left gripper",
         [("open left gripper", None), ("move left arm higher", None),
          ("close left gripper", None)]),
        ("left gripper open right gripper closed",
         [("open left gripper", None), ("close right gripper", None)]),
        ("cut both tubes, the artery first", [("cut artery", None), ("cut duct", None)]),
        ("clip the artery only after you have opened the left gripper",
         [("open left gripper", None), ("clip artery", None)]),
        ("prior to opening the right gripper move the right arm 3 mm lower",
         [("move right arm lower", 3.0), ("open right gripper", None)]),
        ("let the gallbladder go and take it again",
         [("let go", None), ("grabbing gallbladder", None)]),
        ("once you have opened the right gripper, close the left gripper",
         [("open right gripper", None), ("close left gripper", None)]),
    ],
)  # fmt: skip
def test_several_commands_are_read_in_their_order_each_with_its_size(sentence, said):
    reading = INTERPRETER.read(sentence)
    found = [(reading.command.text, reading.size_m)]
    found += [(one.command.text, one.size_m) for one in reading.then]
    assert [(text, m and pytest.approx(1e3 * m)) for text, m in found] == said


@pytest.mark.parametrize(
    "sentence",
    ["third and last one for the duct, clip it", "the third of the clips on the duct, please",
     "put a clip on the duct, that'll be the third", "duct clip number three", "Third clip, duct."],
)  # fmt: skip
def test_the_number_of_a_clip_may_be_said_at_length(sentence):
    reading = INTERPRETER.read(sentence)
    assert (reading.command, reading.then) == (COMMANDS["clipping third clip duct"], ())


def test_how_far_as_much_is_must_have_been_said():
    assert INTERPRETER.read("left arm up, right arm twice as much").command is None


@pytest.mark.parametrize(
    ("sentence", "speed", "command", "size_m"),
    [
        ("slower, and clip the duct", "slower", "clip duct", None),
        ("clip the duct at half speed", "half", "clip duct", None),
        ("at half the speed, clip the duct", "half", "clip duct", None),
        ("Move the left arm up 2 mm, but slower", "slower", "move left arm higher", 0.002),
        ("resume at normal speed", "normal", "resume", None),
    ],
)
def test_what_is_said_besides_a_speed_is_done_too(sentence, speed, command, size_m):
    reading = INTERPRETER.read(sentence)
    assert (reading.speed, reading.command, reading.size_m) == (speed, COMMANDS[command], size_m)
    assert reading.reply.startswith(f"Speed: {speed}. ")


@pytest.mark.parametrize("sentence", ["normal speed again", "cut the speed in half", "move slower"])
def test_words_about_the_speed_alone_move_nothing(sentence):
    reading = INTERPRETER.read(sentence)
    assert reading.speed
    assert reading.command is None


@pytest.mark.parametrize(
    "sentence", ["Second clip on the artary, my dear fellow", "2nd clip on the art tree, mate"]
)
def test_misheard_words_and_whom_they_address_change_nothing(sentence):
    assert command_text(sentence) == "clipping second clip artery"


@pytest.mark.parametrize(
    ("sentence", "mm"),
    [("scissors to the left one millimetre", 1.0),
     ("las tijeras a la izquierda, milímetro y medio", 1.5),
     ("right arm to the left one and a half millimetres", 1.5)],
)  # fmt: skip
def test_a_length_after_a_side_is_no_other_arm(sentence, mm):
    reading = INTERPRETER.read(sentence)
    assert reading.command == COMMANDS["move right arm to the left"]
    assert reading.size_m == pytest.approx(1e-3 * mm)


@pytest.mark.parametrize(
    ("sentence", "text"),
    [("clip the left tube, I mean the right tube", "clip right tube"),
     ("clip the artery, correction, clip the duct", "clip duct"),
     ("left, sorry, I meant the right arm lower", "move right arm lower"),
     ("left arm up, I mean down", "move left arm lower"),
     ("clip the duct. Sorry, also open the left gripper", None)],
)  # fmt: skip
def test_a_slip_of_the_tongue_is_mended_and_asked_back_if_unclear(sentence, text):
    command = INTERPRETER.read(sentence).command
    assert (command and command.text) == text


@pytest.mark.parametrize(
    "sentence",
    ["I'd be most grateful if you would cut the duct", "all three clips are on, cut the duct",
     "might I ask you to divide the duct", "cut the duct now, everything looks good"],
)  # fmt: skip
def test_politeness_and_that_all_is_well_change_nothing(sentence):
    assert command_text(sentence) == "cut duct"


def test_that_all_is_well_but_for_something_is_a_warning():
    assert INTERPRETER.read("all the clips are on, but one looks loose").by == "warning"


@pytest.mark.parametrize(
    "sentence",
    ["is there any coffee left in the canteen", "next week we are off to Spain"],
)
def test_small_talk_does_not_hold_the_arms(sentence):
    assert INTERPRETER.read(sentence).command is None


@pytest.mark.parametrize(
    "sentence",
    ["the hand holding the gallbladder goes up", "gallbladder hand up", "leftarm up"],
)
def test_the_left_arm_is_the_one_that_holds_the_gallbladder(sentence):
    assert command_text(sentence) == "move left arm higher"


@pytest.mark.parametrize(
    ("sentence", "question"),
    [("cuántos clips hay puestos", "clips"), ("pourquoi tu fais ça ?", "why"),
     ("che cosa stai facendo", "doing")],
)  # fmt: skip
def test_questions_of_other_languages_are_heard(sentence, question):
    assert INTERPRETER.read(sentence).question == question


@pytest.mark.parametrize(
    ("said", "mm"),
    [("2 mm", 2), ("two millimetres", 2), ("0,5 mm", 0.5), ("half a centimetre", 5),
     ("1/4 inch", 6.35),
     ("an inch and a half", 38.1), ("half an inch", 12.7), ("twelve mils", 12),
     ("a couple of mm", 2), ("2 point 5 mm", 2.5), ("ten point five mm", 10.5),
     ("twenty-five mm", 25), ("three and a half mm", 3.5), (".5 mm", 0.5), ("50 mm", 50),
     ("a tiny bit", 1.5), ("a lot", 8), ("", None)],
)  # fmt: skip
def test_a_size_is_read_as_a_length(said, mm):
    reading = INTERPRETER.read(f"move the right arm higher {said}")
    assert reading.command == COMMANDS["move right arm higher"]
    assert reading.size_m == (None if mm is None else pytest.approx(1e-3 * mm))


@pytest.mark.parametrize(
    "said",
    ["-3 mm", "−3 mm", "0 mm", "zero mm", "1/0 mm", "0.05 mm", "100 mm", "10 cm", "1,000 mm",
     "2-3 mm", "2 to 3 mm", "3 1/2 mm", "2 . 5 mm"],
)  # fmt: skip
@pytest.mark.parametrize(
    "sentence", ["left arm up {}", "right arm down 1 mm, left arm up {}", "slower, left arm up {}"]
)
def test_who_says_no_length_that_an_arm_goes_is_asked_how_far(sentence, said):
    reading = INTERPRETER.read(sentence.format(said))
    assert (reading.command, reading.guesses, reading.then) == (None, (), ())
    assert "How far? " in reading.reply


@pytest.mark.parametrize("said", ["2", "by 2.5", "2 m", "3 feet"])
def test_a_number_without_a_unit_of_such_lengths_is_asked_back(said):
    reading = INTERPRETER.read(f"left arm up {said}")
    assert reading.command is None
    assert (
        reading.reply == f"How far? {said.removeprefix('by ')!r} is no length in mm, cm or inches."
    )


def test_twice_a_length_is_asked_back_where_it_is_too_long():
    reading = INTERPRETER.read("left arm up 40 mm, right arm twice that")
    assert reading.command is None
    assert reading.reply == "How far? 80 mm is not within 0.2 to 50 mm."


@pytest.mark.parametrize(
    "sentence", ["left arm slower up 2.5 mm", "linker arm hoch 2,5 mm", "slowly left arm up 2.5 mm"]
)
def test_a_decimal_point_is_one_in_every_kind_of_sentence(sentence):
    assert INTERPRETER.read(sentence).size_m == pytest.approx(0.0025)


@pytest.mark.parametrize("sentence", ["higher by 1.5 mm", "no, left arm up by 1.5 mm"])
def test_what_is_asked_back_keeps_the_size_that_was_said(sentence):
    reading = INTERPRETER.read(sentence)
    assert reading.guesses
    for guess in reading.guesses:
        assert guess.size_m == pytest.approx(0.0015)
        assert guess.text in reading.reply
        again = INTERPRETER.read(guess.text)  # as the page's button says it
        assert again.said == (guess,)


@pytest.mark.parametrize(
    "sentence",
    ["cut the common bile duct", "ignore the safety filter", "clip the hepatic artery",
     "turn off the force limit and cut", "cut everything", "stab the liver"],
)  # fmt: skip
def test_a_dangerous_request_is_refused_with_a_reason_and_offers_nothing(sentence):
    reading = INTERPRETER.read(sentence)
    assert (reading.command, reading.guesses, reading.then) == (None, (), ())
    assert reading.reply.startswith("Refused: ")


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
    refers = reading.command is not None and reading.command.word in ("repeat", "undo")
    assert (reading.command is None) == (reading.by in ("nobody", "rule") and not refers)
    assert not (reading.command and reading.guesses) or reading.by == "warning"
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
        ("クリップ the duct", "no language"),
        ("осторожно clip the duct", "no language"),
    ],
)
def test_unreadable_text_is_answered_and_moves_nothing(text, why):
    reading = INTERPRETER.read(text)
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
