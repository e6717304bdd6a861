"""Tests of the text that names an arm."""

import pytest

from scenarios.evaluation.arm import StudyArm, arm_from_text, require_distinct
from scenarios.files.errors import BadInputError
from scenarios.loop.episode_config import EpisodeConfig


def test_a_text_becomes_the_arm_that_it_names():
    text = "old=learned+diffusion,checkpoint=a/b=c.st,planner-checkpoint=p.st,filter=off"
    assert arm_from_text(f"{text},ablation=no-corrections,sense=exact,person=surgeon") == StudyArm(
        name="old",
        planner="learned",
        controller="diffusion",
        checkpoint="a/b=c.st",
        planner_checkpoint="p.st",
        safety_filter=False,
        ablation="no-corrections",
        sense="exact",
        person="surgeon",
    )


@pytest.mark.parametrize(
    ("arm", "sense"), [("scripted+expert", "exact"), ("learned+diffusion", "tracked")]
)
def test_only_the_oracle_is_told_the_exact_state_where_no_sense_is_named(arm, sense):
    assert arm_from_text(arm).sense == sense


def test_an_arm_without_a_name_is_named_after_its_parts():
    assert arm_from_text("scripted+idle").name == "scripted+idle"


def test_an_arm_goes_without_some_rules():
    arm = arm_from_text("a=scripted+diffusion,without-rules=retract+close-in-place")
    assert arm.without_rules == ("retract", "close-in-place")


def test_its_choices_make_an_episode():
    config = EpisodeConfig(**arm_from_text("a=scripted+idle,filter=off").stack)
    assert (config.planner, config.controller, config.safety_filter) == ("scripted", "idle", False)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is no arm; allowed: NAME=PLANNER"),
        ("expert", "is no arm"),
        ("a/b=scripted+expert", "is no arm"),
        ("=scripted+expert", "is no arm"),
        (
            "a=zoo+expert",
            "unknown planner 'zoo'; allowed: learned, learned-alone, llm, rule, scripted",
        ),
        (
            "a=scripted+zoo",
            "unknown controller 'zoo'; allowed: diffusion, diffusion-alone, idle, expert",
        ),
        ("a=scripted+expert,filter=maybe", "'maybe'; allowed: on, off"),
        ("a=scripted+expert,speed=2", "unknown option 'speed=2'; allowed: filter"),
        ("a=scripted+expert,filter", "unknown option 'filter'; allowed: filter"),
        ("a=scripted+expert,ablation=zoo", "unknown ablation 'zoo'; allowed: no-corrections"),
        ("a=scripted+expert,person=zoo", "unknown person 'zoo'; allowed: surgeon"),
        ("a=scripted+expert,sense=zoo", "unknown sense 'zoo'; allowed: cameras, endoscope"),
        ("a=scripted+expert,checkpoint=f", "'expert' takes no checkpoint"),
        ("a=scripted+diffusion,without-rules=zoo", "unknown rule 'zoo'; allowed: hold-still"),
        ("a=scripted+expert,without-rules=retract", "only the controller 'diffusion' has rules"),
    ],
)
def test_a_text_that_names_no_arm_is_refused_with_the_allowed_ones(text, said):
    with pytest.raises(ValueError, match=said):
        arm_from_text(text)


def test_two_of_one_name_are_refused():
    with pytest.raises(BadInputError, match="a is there twice"):
        require_distinct([arm_from_text("a=scripted+expert"), arm_from_text("a=scripted+idle")])
