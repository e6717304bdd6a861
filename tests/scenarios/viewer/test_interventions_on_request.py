"""Tests of saved interventions: a guided arm is one, and its frames are marked for imitation."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from controller.dataset.part import read_part
from planner.command import COMMANDS
from scenarios.catalogue import ORACLE
from scenarios.demonstration.interventions import Interventions
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.guided_arm import GuidedArm
from scenarios.loop.person.inbox import Inbox
from scenarios.run_episode import begin
from scenarios.viewer.session_state import InterventionsOnRequest
from tissue_sim.tools.arms import RIGHT_ARM


def test_who_leads_an_arm_in_a_hold_only_has_not_intervened_yet(tmp_path):
    inbox = Inbox()
    config = EpisodeConfig(**ORACLE, scenario="textbook", seed=9_002)
    episode = begin(config, inbox=inbox)
    seen = InterventionsOnRequest(tmp_path, config)
    seen.on_reset(episode.world)
    inbox.press(COMMANDS["pause"])
    T = episode.world.arms.T_world_tool()[RIGHT_ARM]
    inbox.guided = GuidedArm(arm=RIGHT_ARM, T_world_goal=T, jaw_rad=0.3)
    for k, step in enumerate(islice(episode.steps(), 20), start=1):
        assert step.guided is not None
        seen.on_step(step)
        if k == 10:
            with pytest.raises(ValueError, match="outside a hold"):
                seen.save_so_far()
            inbox.press(COMMANDS["resume"])
    assert len(read_part(seen.save_so_far())) == 10


@pytest.mark.parametrize("expert", [True, False])
def test_only_the_expert_and_a_guided_arm_are_marked_for_imitation(tmp_path, expert):
    """Check 60 steps: the arms hold from step 20 to 30, a person guides one from step 40 on."""
    inbox = Inbox()
    config = EpisodeConfig(**ORACLE, scenario="textbook", seed=9_002)
    episode = begin(config, inbox=inbox)
    seen = InterventionsOnRequest(
        tmp_path, config if expert else replace(config, controller="idle")
    )
    seen.on_reset(episode.world)
    for k, step in enumerate(islice(episode.steps(), 60), start=1):
        seen.on_step(step)
        if k == 20:
            inbox.press(COMMANDS["pause"])
        if k == 30:
            inbox.press(COMMANDS["resume"])
        if k == 40:
            assert not seen.intervened
            with pytest.raises(ValueError, match="nobody has corrected"):
                seen.save_so_far()
            T = episode.world.arms.T_world_tool()[RIGHT_ARM]
            inbox.guided = GuidedArm(arm=RIGHT_ARM, T_world_goal=T, jaw_rad=0.3)
    assert seen.intervened
    columns = read_part(seen.save_so_far()).columns
    guided = np.arange(50) >= 30
    np.testing.assert_array_equal(columns["expert"], np.ones(50, bool) if expert else guided)
    assert len(np.unique(columns["segment"])) == 2


@pytest.mark.parametrize("seed", [10_000, 20_000])
@pytest.mark.parametrize("kind", [Interventions, InterventionsOnRequest])
def test_a_patient_who_tests_what_was_learned_is_never_training_data(tmp_path, seed, kind):
    config = EpisodeConfig(**ORACLE, scenario="textbook", seed=seed)
    inbox = Inbox()
    episode = begin(config, inbox=inbox)
    seen = kind(tmp_path, config)
    seen.on_reset(episode.world)
    inbox.press(COMMANDS["move right arm higher"])
    for step in islice(episode.steps(), 3):
        seen.on_step(step)
    assert seen.intervened
    with pytest.raises(ValueError, match=f"seed {seed} is no training patient"):
        seen.save(success=True, failures=[])
    assert not list(tmp_path.iterdir())
