"""Tests of sentences read as a whole: permissions, resumptions, relative orders, silence."""

import time

import pytest

from planner.language.interpreter import Interpreter
from planner.language.sentence_sets import Row
from planner.person.prohibition import Prohibition
from tests.planner.language.scoring import read_as

READ = Interpreter().read
CUT_DUCT = Prohibition(act="cut", on="duct")


def allowed(act, on=""):
    return Prohibition(act=act, on=on)


def word_of(reading):
    return reading.command and reading.command.word


def after(latest, said):
    return read_as(Row(f"[after: {latest}] {said}", ""), READ)


@pytest.mark.parametrize(
    ("permission", "ban"),
    [
        ("you may cut the duct now", "you may not cut the duct now"),
        ("Jetzt darfst du den Gang durchtrennen", "Du darfst den Gang nicht durchtrennen"),
        ("Tu peux couper le canal maintenant", "Tu ne peux pas couper le canal"),
        ("Ya puedes cortar el conducto", "No puedes cortar el conducto"),
        ("Ora puoi tagliare il dotto", "Non puoi tagliare il dotto"),
        ("现在允许剪胆囊管", "现在不允许剪胆囊管"),
        ("the ban on cutting the duct is lifted", "the ban on cutting the duct is not lifted"),
        ("the duct is no longer off limits for scissors", "the duct is off limits for scissors"),
        ("I authorise you to cut the duct", "I do not authorise you to cut the duct"),
        ("permission granted to cut the duct", "permission to cut the duct is refused"),
    ],
)
def test_a_permission_is_heard_and_its_ban_is_never_one(permission, ban):
    allows, forbids = READ(permission), READ(ban)
    assert (allows.allows, allows.forbids) == (CUT_DUCT, ())
    assert CUT_DUCT in forbids.forbids
    assert (forbids.allows, forbids.may_allow) == (None, None)


@pytest.mark.parametrize(
    ("said", "act"),
    [
        ("you have my permission to divide the duct", CUT_DUCT),
        ("Tu peux clipper l'artère maintenant", allowed("clip", "artery")),
        ("the duct is clipped, you may cut it", CUT_DUCT),
        ("Forget what I told you about never opening the left gripper, it's allowed",
         allowed("open", "left gripper")),
        ("clipping is fine again from my side", allowed("clip")),
    ],
)  # fmt: skip
def test_permissions_are_as_broad_as_bans(said, act):
    assert READ(said).allows == act


@pytest.mark.parametrize(
    "said",
    [
        "he says you may cut the duct", "you may cut the duct once I say so",
        "perhaps you may cut the duct", "the ban on cutting will be lifted tomorrow",
        "may you cut the duct?", "Darf ich den Gang schneiden?", "who said you may cut the duct",
        "only the consultant may allow cutting the duct", "allow me to cut the duct",
        "I take my permission to cut the duct back",
        "forget what I said about cutting being allowed",
        "forget that you may cut the duct", "the ban on cutting the duct has not been lifted",
        "Du darfst erst schneiden, wenn ich es sage", "puedes cortar cuando yo diga",
        "nobody said you may cut the duct", "cutting is allowed under no circumstances",
    ],
)  # fmt: skip
def test_who_asks_reports_denies_or_sets_a_time_lifts_nothing(said):
    assert READ(said).allows is None


@pytest.mark.parametrize(
    "said",
    [
        "as you were", "false alarm, proceed", "weiter geht's", "Fausse alerte, continuez",
        "Falsa alarma, sigue", "Falso allarme, prosegui pure", "虚惊一场,继续",
        "okay bleeding's controlled, you can proceed", "all yours again", "back to autopilot",
    ],
)  # fmt: skip
def test_all_ways_to_say_go_on_are_heard(said):
    reading = READ(said)
    assert word_of(reading) == "resume"


@pytest.mark.parametrize(
    "said",
    [
        "the bleeding has not stopped, go on", "do not carry on", "it was only an artery, go on",
        "false alarm? no, carry on looking", "carry on at your peril, stop",
    ],
)  # fmt: skip
def test_what_also_warns_lets_nothing_go_on(said):
    reading = READ(said)
    assert word_of(reading) in (None, "stop", "pause")


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("a little more", "move right arm higher @ 1.5 mm"),
        ("just a hair", "move right arm higher @ 1.5 mm"),
        ("half that", "move right arm higher @ 2 mm"),
        ("the other one", "move left arm higher @ 4 mm"),
        ("same with the left arm", "move left arm higher @ 4 mm"),
        ("down again by the same amount", "move right arm lower @ 4 mm"),
        ("back by half", "move right arm lower @ 2 mm"),
        ("2 mm more", "move right arm higher @ 2 mm"),
        ("too far, a bit back", "move right arm lower @ 1.5 mm"),
        ("再低一点", "move right arm lower @ 1.5 mm"),
        ("noch ein bisschen", "move right arm higher @ 1.5 mm"),
        ("Lo mismo con el otro brazo", "move left arm higher @ 4 mm"),
        ("again", "move right arm higher @ 4 mm"),
    ],
)
def test_relative_words_go_by_the_latest_order(said, meant):
    assert after("move right arm higher @ 4 mm", said) == meant


@pytest.mark.parametrize(
    ("said", "size_mm"),
    [
        ("right arm up two and a half millimetres", 2.5), ("right arm up a dozen millimetres", 12),
        ("right arm up a millimetre and a half", 1.5), ("right arm up half a millimetre", 0.5),
        ("rechter Arm anderthalb Millimeter nach oben", 1.5),
        ("rechter Arm siebzehn Millimeter nach oben", 17),
        ("bras droit plus haut de vingt deux millimètres", 22),
        ("brazo derecho arriba doce milímetros", 12),
        ("braccio destro più in alto di dodici millimetri", 12), ("右臂往上两毫米半", 2.5),
        ("右臂往上十二毫米", 12),
    ],
)  # fmt: skip
def test_lengths_are_read_in_six_languages(said, size_mm):
    reading = READ(said)
    assert reading.command
    assert reading.command.text == "move right arm higher"
    assert reading.size_m == pytest.approx(1e-3 * size_mm)


@pytest.mark.parametrize("number", ["1e3", "1e308", "nan", "inf", "fif-something", "2..,5,3", "x"])
def test_a_number_that_cannot_be_read_asks_back(number):
    reading = READ(f"right arm up by {number} mm")
    assert reading.command is None
    assert reading.reply.startswith("How far?")


@pytest.mark.parametrize(
    "said",
    [
        "[BLANK_AUDIO]", "...", "♪", "♪ ♪", "?!", "(upbeat music)", "*coughs*", "[Applaus]",
        "Thank you for watching!", "Please like and subscribe", "you", "Okay.", "Right.",
        "Sous-titrage ST' 501", "Untertitel im Auftrag des ZDF", "谢谢观看",
        "Gracias por ver el video",
        "Sottotitoli creati dalla comunità Amara.org", "Vale, muy bien.", "嗯,好的", "Bon, voilà.",
    ],
)  # fmt: skip
def test_what_holds_no_word_does_nothing(said):
    reading = READ(said)
    assert (reading.command, reading.guesses, reading.question) == (None, (), None)


@pytest.mark.parametrize(
    "said",
    ["(bleeding)", "[stop]", "uh oh", "*halt*", "Bon, non.", "好,停", "Okay, whoa.", "no no"],
)
def test_a_warning_among_them_is_heard(said):
    reading = READ(said)
    assert word_of(reading) in ("stop", "pause")


STOPS = (
    "st\u200bop", "s\x00top", "ѕtор", "ЅТОР", "ｓｔｏｐ", "𝐬𝐭𝐨𝐩", "s t o p", "s-t-o-p!", "stoooop",
    "let me take over", "I'll take it from here", "my turn", "hands off", "ich übernehme",
    "je prends la main", "lascia fare a me", "让我来",
)  # fmt: skip


@pytest.mark.parametrize("said", STOPS)
def test_a_stop_is_heard_however_it_is_written(said):
    reading = READ(said)
    assert word_of(reading) == "stop"


@pytest.mark.parametrize("before", ["lorem ipsum dolor ", "lörem ipsüm ", "的", "a-", "["])
def test_a_stop_is_heard_at_the_end_of_a_long_text(before):
    text = before * (100_000 // len(before)) + " stop"
    READ(text)
    begun = time.process_time()
    reading = READ(text)
    assert time.process_time() - begun < 0.5  # 0.05 s on a machine without other work
    assert word_of(reading) == "stop"


@pytest.mark.parametrize(
    "text", ["so much " * 24, "please like and subscribe " * 7, "continue ok please now " * 8]
)
def test_a_text_of_known_phrases_is_read_at_once(text):
    begun = time.process_time()
    READ(text + "x")
    assert time.process_time() - begun < 0.5


@pytest.mark.parametrize(
    ("said", "kind"),
    [
        ("Wo ist die Schere hin?", "where"), ("Ist der Gang schon durchtrennt?", "cut"),
        ("¿Dónde está la vesícula?", "where"), ("Dov'è l'arteria?", "where"),
        ("Quel tube est le canal cystique ?", "which"), ("现在剪安全吗?", "safe"),
        ("还要多久?", "left"), ("Was ist gerade verboten?", "forbidden"),
        ("Sei sicuro che sia il dotto?", "sure"), ("Hältst du die Gallenblase noch?", "held"),
        ("how sure are you that this is the duct?", "sure"), ("Is the duct cut?", "cut"),
        ("Which one of these two is the artery?", "which"),
    ],
)  # fmt: skip
def test_questions_are_answered_in_six_languages_and_hold_no_arm(said, kind):
    reading = READ(said)
    assert (reading.question, reading.command) == (kind, None)


@pytest.mark.parametrize("said", ["are you sure?!", "was machst du denn da?!", "was soll das?"])
def test_a_question_that_is_a_warning_holds(said):
    reading = READ(said)
    assert word_of(reading) == "stop"
