"""Laws of the planner's training: it learns, and goes on exactly where it stopped."""

from dataclasses import replace
from functools import partial

import pytest

from planner.learned import training
from planner.learned.checkpoint import FITS, load_checkpoint, save_checkpoint
from planner.learned.network import PlannerNetwork
from planner.learning.checkpoint import CheckpointError
from tests.planner.learned.rolled_out import rollout
from tests.resuming import goes_on_where_it_stopped

SMOKE = training.PRESETS["smoke"]
GIVEN = [rollout(seed) for seed in range(3)]


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    out = tmp_path_factory.mktemp("trained")
    return out, list(training.train(GIVEN, SMOKE, out))


def weights(out) -> dict:
    return load_checkpoint(out / training.CHECKPOINT_FILE).state_dict()


def test_the_loss_falls(trained):
    _, steps = trained
    first, last = (sum(s.loss for s in part) / 10 for part in (steps[:10], steps[-10:]))
    assert last < 0.7 * first


def test_stopped_and_taken_up_again_it_ends_at_the_same_weights(trained, tmp_path):
    train = partial(training.train, GIVEN, SMOKE)
    assert goes_on_where_it_stopped(train, weights, trained, tmp_path, SMOKE.save_every)


def test_other_rollouts_do_not_go_on_from_there(trained):
    with pytest.raises(ValueError, match="of other demonstrations"):
        next(training.train(GIVEN[:1], SMOKE, trained[0]))


def test_another_configuration_does_not_go_on_from_there(trained):
    with pytest.raises(ValueError, match="of another configuration"):
        next(training.train(GIVEN, replace(SMOKE, batch=32), trained[0]))


@pytest.mark.parametrize("what", FITS)
def test_a_checkpoint_for_something_else_is_refused_in_one_line(what, tmp_path, monkeypatch):
    path = tmp_path / "planner.safetensors"
    with monkeypatch.context() as patch:
        patch.setitem(FITS, what, 999)
        save_checkpoint(path, PlannerNetwork(SMOKE.planner))
    with pytest.raises(CheckpointError, match=f"{what} 999, but here it is") as refusal:
        load_checkpoint(path)
    assert "\n" not in str(refusal.value)
