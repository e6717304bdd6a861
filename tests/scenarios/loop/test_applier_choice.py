"""Tests of who chooses the mounted clip applier: a person, else the planner, else the nurse."""

from itertools import islice

import pytest

from planner.instruction import Instruction
from planner.procedure.cholecystectomy import task_from_text
from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tests.scenarios.loop.saying import Saying
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import CLIP_APPLIER, SLIM_CLIP_APPLIER

SEED = 10_003  # its duct is 3.7 mm wide, so both kinds of clip fit
EXCHANGED = 80  # steps, more than an exchange takes


@pytest.mark.parametrize(
    ("text", "tool"),
    [
        ("the weather is nice", SLIM_CLIP_APPLIER),
        ("use the polymer clip", CLIP_APPLIER),
        ("use the titanium clip", SLIM_CLIP_APPLIER),
    ],
)
def test_the_nurse_mounts_the_applier_that_a_person_chooses_where_its_clip_fits(text, tool):
    mounts(tool, planned="", text=text)


@pytest.mark.parametrize(
    ("planned", "text", "tool"),
    [
        (CLIP_APPLIER, "", CLIP_APPLIER),
        (SLIM_CLIP_APPLIER, "", SLIM_CLIP_APPLIER),
        (CLIP_APPLIER, "use the titanium clip", SLIM_CLIP_APPLIER),
    ],
)
def test_the_nurse_mounts_the_planners_applier_unless_a_person_chooses_another(planned, text, tool):
    mounts(tool, planned=planned, text=text)


def mounts(tool, *, planned, text):
    """Run an episode whose planner names a tool, and require the tool that the arm gets."""
    clips = Instruction(task=task_from_text("clipping first clip left tube"), tool=planned)
    config = EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED)
    episode = begin(config, planner=Saying(clips))
    assert not episode.world.anatomy.artery_on_left
    if text:
        episode.inbox.say(text)
    steps = list(islice(episode.steps(), EXCHANGED))
    assert steps[-1].instruction.tool == tool
    assert steps[-1].observation.tools[RIGHT_ARM] == tool
    assert steps[-1].observation.clip_loaded
