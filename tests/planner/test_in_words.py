"""Tests of the scene in words: it names what is seen, in the directions of corrections."""

from dataclasses import replace

import numpy as np
import pytest

from planner.correction import DIRECTION_ENDOSCOPE
from planner.scene.in_words import scene_in_words, way_in_words
from tests.planner.observations import clipped, writable
from tissue_sim.tools.arms import RIGHT_ARM

WORDS = {"away": "further away", "towards": "nearer"}


@pytest.mark.parametrize("direction", DIRECTION_ENDOSCOPE)
def test_a_way_is_described_in_the_words_of_corrections(direction):
    way_m = 0.007 * np.array(DIRECTION_ENDOSCOPE[direction])
    assert way_in_words(way_m) == f"7 mm {WORDS.get(direction, direction)}"


def test_a_way_of_no_length_is_right_there():
    assert way_in_words(np.full(3, 0.0004)) == "right there"


def test_following_the_words_leads_to_the_tube():
    seen = writable(clipped())
    seen.tips_endoscope[RIGHT_ARM, :3, 3] = seen.tube_m("right").mean(axis=0)
    seen.tips_endoscope[RIGHT_ARM, :3, 3] -= [0.005, -0.003, 0.02]
    words = (
        "from its tip to the middle of the right tube: 5 mm left, 3 mm lower, 20 mm further away"
    )
    assert words in scene_in_words(seen)
    assert "(21 mm to its axis)" in scene_in_words(seen)


def test_clips_cuts_and_tools_are_named():
    seen = replace(
        clipped(left=3, right=1), severed=np.array([True, False, False]), clip_loaded=False
    )
    words = scene_in_words(seen)
    assert "Left tube (duct): 3 clips, in two parts, 100 % straight, 28 mm long at rest." in words
    assert "Right tube (artery): 1 clips, in one part" in words
    assert "clip applier, jaws 0 degrees open, tissue force 0.0 N, without a clip" in words
    assert "without a clip" not in scene_in_words(replace(seen, tools=("grasper", "scissors")))
