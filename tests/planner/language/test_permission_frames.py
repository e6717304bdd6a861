"""Tests of permissions built from frames, acts and structures; of what is nearly one, too."""

from itertools import product
from pathlib import Path

import pytest

from planner.language.interpreter import Interpreter
from planner.language.rules.permission_frames import permitted_by
from planner.language.rules.permitting import permission_in
from planner.language.sentence_sets import keeps_the_protocol, read_rows
from planner.person.prohibition import Prohibition
from tests.planner.language.scoring import is_right, read_as

READ = Interpreter().read
OWN = Path(__file__).with_name("sets") / "permissions.tsv"
FRAMES = {  # do: cut, doing: cutting, on: the duct
    "english": (
        "you may {do} {on}", "you are allowed to {do} {on}", "you're cleared to {do} {on} now",
        "{doing} {on} is permitted again", "{doing} {on} is fine by me", "{on} may be {done}",
        "green light for {doing} {on}", "you have my permission to {do} {on}",
        "permission to {do} {on} granted", "I authorise you to {do} {on}",
        "I approve {doing} {on}", "it's all right if you {do} {on}", "feel free to {do} {on}",
        "the ban on {doing} {on} is lifted", "I lift the ban on {doing} {on}",
        "cancel my veto on {doing} {on}",
    ),
    "english, a denial that ends a ban": (
        "no objection to {doing} {on}", "I have no further objection to you {doing} {on}",
        "nothing against {doing} {on} any more", "I don't mind you {doing} {on}",
        "I no longer mind if you {do} {on}", "{doing} {on} is no longer forbidden",
        "I no longer forbid {doing} {on}", "the ban on {doing} {on} no longer applies",
        "you need not refrain from {doing} {on} any longer",
        "forget what I said about never {doing} {on}",
    ),
    "german": (
        "du darfst {on} {do}", "{doing} ist wieder erlaubt", "ich erlaube dir, {on} zu {do}",
        "grünes Licht zum {doing}", "das Verbot, {on} zu {do}, ist aufgehoben",
    ),
    "french": (
        "tu peux {do} {on}", "il est permis de {do} {on}", "{do} {on} est autorisé",
        "je t'autorise à {do} {on}", "feu vert pour {do} {on}",
        "je lève l'interdiction de {do} {on}",
    ),
    "spanish": (
        "puedes {do} {on}", "está permitido {do} {on}", "te autorizo a {do} {on}",
        "luz verde para {do} {on}", "levanto la prohibición de {do} {on}",
    ),
    "italian": (
        "puoi {do} {on}", "è permesso {do} {on}", "ti autorizzo a {do} {on}",
        "via libera per {do} {on}", "il divieto di {do} {on} è revocato",
    ),
    "chinese": ("可以{do}{on}", "我同意{do}{on}", "现在允许{do}{on}了", "解除{do}{on}的禁令"),
}  # fmt: skip
ACTS = {  # do, doing, done
    "english": (("cut", "cut", "cutting", "cut"), ("clip", "clip", "clipping", "clipped"),
                ("open", "open", "opening", "opened")),
    "german": (("cut", "schneiden", "Schneiden", ""), ("clip", "clippen", "Clippen", ""),
               ("open", "öffnen", "Öffnen", "")),
    "french": (("cut", "couper", "", ""), ("clip", "clipper", "", ""), ("open", "ouvrir", "", "")),
    "spanish": (("cut", "cortar", "", ""), ("clip", "clipar", "", ""), ("open", "abrir", "", "")),
    "italian": (("cut", "tagliare", "", ""), ("clip", "clippare", "", ""),
                ("open", "aprire", "", "")),
    "chinese": (("cut", "剪断", "", ""), ("clip", "夹闭", "", ""), ("open", "打开", "", "")),
}  # fmt: skip
THINGS = {
    "english": {"duct": "the duct", "right tube": "the right tube",
                "left gripper": "the left jaws"},
    "german": {"duct": "den Gang", "artery": "die Arterie", "left gripper": "den linken Greifer"},
    "french": {"duct": "le canal", "artery": "l'artère", "left gripper": "la pince gauche"},
    "spanish": {"duct": "el conducto", "artery": "la arteria",
                "right gripper": "la pinza derecha"},
    "italian": {"duct": "il dotto", "artery": "l'arteria", "right gripper": "la pinza destra"},
    "chinese": {"duct": "胆囊管", "artery": "动脉", "left gripper": "左钳"},
}  # fmt: skip
NO = {"english": ("not", "never"), "german": ("nicht", "nie"), "french": ("pas", "jamais"),
      "spanish": ("no", "nunca"), "italian": ("non", "mai"), "chinese": ("不", "别")}  # fmt: skip


def permissions(*, denials=True):
    """Yield (language, sentence, what it permits) for each frame, act and structure."""
    for kind, frames in FRAMES.items():
        language = kind.split(",")[0]
        if kind != language and not denials:
            continue
        for frame, (act, do, doing, done), (on, thing) in product(
            frames, ACTS[language], THINGS[language].items()
        ):
            if (act == "open") == on.endswith("gripper"):
                named = on if "{on}" in frame else ""
                said = frame.format(do=do, doing=doing, done=done, on=thing)
                yield language, said, Prohibition(act=act, on=named)


def allows(said):
    """Return whether a text allows anything, or may."""
    reading = READ(said)
    return reading.allows or reading.may_allow


def test_every_frame_with_every_act_permits_it():
    wrong = [(said, act, READ(said).allows) for _, said, act in permissions()
             if READ(said).allows != act]  # fmt: skip
    assert not wrong


def test_a_denial_anywhere_in_a_frame_permits_nothing():
    """Set each denial before each word: no ban that one word makes of a permission is one."""
    heard = list[str]()
    for language, said, _ in permissions(denials=False):
        words = list(said) if language == "chinese" else said.split()
        joint = "" if language == "chinese" else " "
        for no, k in product(NO[language], range(len(words))):
            denied = joint.join((*words[:k], no, *words[k:]))
            if permission_in(denied, denied):
                heard.append(denied)
    assert not heard


@pytest.mark.parametrize(
    "besides",
    [
        "{}?", "he says {}", "{} if I say so", "{} once the artery is clipped", "perhaps {}",
        "nobody said {}", "{} over my dead body", "{}, but not yet", "who told you that {}",
        "I did not say {}", "{} tomorrow",
    ],
)  # fmt: skip
def test_who_asks_reports_denies_or_sets_a_condition_surely_permits_nothing(besides):
    english = [said for language, said, _ in permissions() if language == "english"]
    assert not [said for said in map(besides.format, english) if READ(said).allows]


@pytest.mark.parametrize(
    "said",
    [
        "Ich hebe das Verbot zu schneiden nicht auf", "Ich hebe mein Schneidverbot noch nicht auf",
        "Je ne lève pas l'interdiction de couper le canal",
        "No levanto la prohibición de cortar", "Non tolgo il divieto di tagliare il dotto",
    ],
)  # fmt: skip
def test_who_does_not_end_a_ban_permits_nothing(said):
    assert not allows(said)


@pytest.mark.parametrize(
    "said",
    [
        "your cutting is fine", "the clip is ok", "the cut is fine", "the clip is back on",
        "clips are on", "OK, transect the right tube", "va bene, taglia il dotto",
        "bien, corta el conducto", "the duct is free", "I forbid cutting the duct",
        "the ban on cutting the duct is on", "I withdraw my permission to cut the duct",
        "I have an objection to cutting the duct", "I mind if you cut the duct",
        "I no longer allow cutting the duct", "you may cut the duct and clip the artery",
    ],
)  # fmt: skip
def test_a_report_an_order_and_a_ban_are_not_built_like_a_permission(said):
    assert permitted_by(said) is None


def test_permissions_by_the_mender_are_heard():
    """Hold the score after the rule was written; 31 of the 60 were right before."""
    rows = read_rows(OWN, keeps_the_protocol)
    right = [row for row in rows if is_right(row.expected, read_as(row, READ))]
    assert (len(right), len(rows)) == (58, 60)
