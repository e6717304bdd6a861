"""Tests of every scenario: observations, seeds, saved states, the expert and the idle controller.

Marked `slow`: the whole procedures except that of `nominal`, and scenarios like another one.
"""

from itertools import islice

import numpy as np
import pytest

from scenarios.catalogue import ORACLE, SCENARIOS, SENSE_OF, SENSES
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.snapshot import Snapshot
from scenarios.run_episode import anatomy_of, begin, run_episode
from tests.scenarios.procedures import run
from tissue_sim.sensing.observation import MAX_CLIPS, VECTOR_LAYOUT, VECTOR_SIZE, fields

SEED, OTHER_SEED = 10_030, 10_037  # for both nobody need be called
BEFORE, AFTER = 15, 45  # steps: the arms move; in the second part a perturbation may lead one
IDLE_CAP_S = 20.0  # longer than any task takes the expert
PICTURED = [name for name, sense in SENSES.items() if sense.renders]
WITHOUT_PICTURES = [name for name in SCENARIOS if SENSE_OF.get(name) not in PICTURED]
ONE_OF_A_KIND = (  # the others differ from one of these in a number, an arm or a tube
    *("nominal", "grasp-missed-above", "wrong-tube", "clip-dropped", "grasp-slip", "breathing"),
    *("camera-turn", "latency", "stiff-tissue", "dye", "artery-in-front", "two-arteries", "fat"),
)
LATER = {"forces_n", "pinch_n", "clips_m", "n_clips", "clip_loaded", "right_tool", "severed"}
OF_SENSES = {  # sensed exactly: still
    *("tube_radius_m", "rest_length_m", "rest_length_std_m"),
    *("third_tube", "std_m", "age_s", "hidden"),
}


def config(scenario, **changes):
    sense = SENSE_OF.get(scenario, "exact")
    usual = ORACLE | {"scenario": scenario, "seed": SEED, "sense": sense}
    return EpisodeConfig(**usual | changes)


def seen(steps, n):
    """Return the next n observations (n, `VECTOR_SIZE`) and the commands (n, 2, 7) before them."""
    taken = list(islice(steps, n))
    return (
        np.stack([step.observation.vector() for step in taken]),
        np.stack([step.command.joints for step in taken]),
    )


def by_default(name):
    return name if name in ONE_OF_A_KIND else pytest.param(name, marks=pytest.mark.slow)


@pytest.fixture(scope="module", params=[by_default(name) for name in WITHOUT_PICTURES])
def started(request):
    """Return a scenario, its first and its later steps, and the snapshot between them."""
    episode = begin(config(request.param))
    running = episode.steps()
    first = seen(running, BEFORE)
    moment = Snapshot(episode)
    return request.param, first, seen(running, AFTER), moment


def test_the_observation_fits_its_spec_and_is_finite(started):
    _, (vectors, _), _, _ = started
    assert vectors.shape == (BEFORE, VECTOR_SIZE)
    assert vectors.dtype == np.float32
    assert np.isfinite(vectors).all()
    assert {name: part.shape[1:] for name, part in fields(vectors).items()} == VECTOR_LAYOUT


def test_every_value_that_can_change_while_arms_move_changes(started):
    _, (first, _), (second, _), _ = started
    parts = fields(np.concatenate([first, second]))
    still = {name for name, part in parts.items() if not np.ptp(part, axis=0).any()}
    assert still <= LATER | OF_SENSES


def test_its_state_is_restored_bit_for_bit(started):
    _, _, (vectors, commands), moment = started
    again, commanded = seen(moment.again().steps(), AFTER)
    np.testing.assert_array_equal(again, vectors)
    np.testing.assert_array_equal(commanded, commands)


def test_the_same_seed_gives_the_same_episode_and_another_seed_another(started):
    name, (first, _), (second, _), _ = started
    np.testing.assert_array_equal(
        seen(begin(config(name)).steps(), BEFORE + AFTER)[0], np.concatenate([first, second])
    )
    assert anatomy_of(config(name, seed=OTHER_SEED)) != anatomy_of(config(name))


def test_every_number_of_the_observation_changes_in_a_procedure(procedure):
    never_still(procedure)


@pytest.mark.slow
@pytest.mark.parametrize("name", WITHOUT_PICTURES)
def test_the_oracle_succeeds_and_sees_everything_change(name, tmp_path):
    procedure = run(config(name), tmp_path)
    assert procedure.result.success
    never_still(procedure)


@pytest.mark.slow
@pytest.mark.parametrize("name", WITHOUT_PICTURES)
def test_the_idle_controller_fails(name):
    result = run_episode(config(name, controller="idle", task_cap_s=IDLE_CAP_S))
    assert result.outcome == "failed"


def never_still(procedure):
    """Check that every number of the observation changes.

    Some may stay: places of clips that were not needed, the fixed ends of tubes and of structures
    at risk, and what an exact sense does not change.
    """
    vectors = np.stack([step.observation.vector() for step in procedure.steps])
    n_clips = procedure.steps[-1].observation.n_clips
    still = {name: ~np.ptp(part, axis=0).astype(bool) for name, part in fields(vectors).items()}
    assert not still.pop("clips_m")[: min(n_clips, MAX_CLIPS)].any()
    there = len(procedure.steps[-1].observation.tubes)
    still["tubes_m"] = still["tubes_m"][:there, 1:]
    still["severed"] = still["severed"][:there]
    for trunk in ("common_bile_duct_m", "hepatic_artery_m"):
        still[trunk] = still[trunk][1:-1]
    still = {name: part for name, part in still.items() if name not in OF_SENSES}
    assert {name: part.sum() for name, part in still.items() if part.any()} == {}
