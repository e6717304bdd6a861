"""Tests of the policies' trainings: they learn, and resume exactly."""

import json
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import islice
from types import ModuleType
from typing import Any

import pytest
import torch
from safetensors.torch import save_file

from controller.diffusion import training as controller_training
from controller.diffusion.policy import CHECKPOINTS as POLICIES
from controller.pixels import training as pixel_training
from controller.pixels.policy import CHECKPOINTS as PIXEL_POLICIES
from planner.learned import training as planner_training
from planner.learned.network import CHECKPOINTS as PLANNERS
from planner.learning.checkpoint import CheckpointError, Checkpoints
from planner.learning.optimise import STATE_FILE
from tests.controller.diffusion.demonstrated import demonstration
from tests.controller.pixels.filmed import film
from tests.planner.learned.rolled_out import rollout
from tests.slow import slow


@dataclass(frozen=True, kw_only=True)
class Learner:
    """Names a policy's training and data; its loss must fall to a share of `falls_to`."""

    name: str
    training: ModuleType
    checkpoints: Checkpoints
    given: list[Any]
    falls_to: float

    @property
    def smoke(self) -> Any:
        return self.training.PRESETS["smoke"]

    def weights(self, out) -> dict:
        return self.checkpoints.load(out / self.training.CHECKPOINT_FILE).state_dict()


LEARNERS = {
    "controller": Learner(
        name="controller",
        training=controller_training,
        checkpoints=POLICIES,
        given=[demonstration(seed=seed) for seed in range(2)],
        falls_to=0.8,
    ),
    "pixels": Learner(
        name="pixels",
        training=pixel_training,
        checkpoints=PIXEL_POLICIES,
        given=[film(seed=seed) for seed in range(2)],
        falls_to=0.8,
    ),
    "planner": Learner(
        name="planner",
        training=planner_training,
        checkpoints=PLANNERS,
        given=[rollout(seed) for seed in range(3)],
        falls_to=0.7,
    ),
}


@pytest.fixture(scope="module", params=LEARNERS)
def learner(request) -> Learner:
    return LEARNERS[request.param]


@pytest.fixture(scope="module")
def trained(learner, made_once):
    def make(out):
        return out, list(learner.training.train(learner.given, learner.smoke, out))

    return made_once(f"trained-{learner.name}", make)


def test_the_loss_falls(learner, trained):
    _, steps = trained
    assert [step.step for step in steps] == list(range(1, learner.smoke.steps + 1))
    first, last = (sum(s.loss for s in part) / 10 for part in (steps[:10], steps[-10:]))
    assert last < learner.falls_to * first


def test_stopped_and_resumed_it_ends_at_the_same_weights(learner, trained, tmp_path):
    out, steps = trained
    train = partial(learner.training.train, learner.given, learner.smoke, tmp_path)
    every = learner.smoke.save_every
    interrupted = train()
    _ = list(islice(interrupted, every + 7))  # 7 steps are lost
    interrupted.close()
    assert list(train()) == steps[every:]
    expected, found = learner.weights(out), learner.weights(tmp_path)
    assert all(torch.equal(weight, expected[name]) for name, weight in found.items())


def test_a_finished_training_writes_its_checkpoint_again_if_it_was_moved(
    learner, trained, tmp_path
):
    out, _ = trained
    (tmp_path / STATE_FILE).write_bytes((out / STATE_FILE).read_bytes())
    assert not list(learner.training.train(learner.given, learner.smoke, tmp_path))
    expected, found = learner.weights(out), learner.weights(tmp_path)
    assert all(torch.equal(weight, expected[name]) for name, weight in found.items())


def test_another_seed_gives_other_weights(learner, tmp_path):
    weights = []
    for seed in (0, 1):
        config, out = replace(learner.smoke, seed=seed, steps=1), tmp_path / str(seed)
        _ = list(learner.training.train(learner.given, config, out))
        weights.append(learner.weights(out))
    matrices = [
        name for name in weights[0] if name.endswith("weight") and weights[0][name].ndim > 1
    ]
    assert matrices
    assert not any(torch.equal(weights[0][name], weights[1][name]) for name in matrices)


def test_another_configuration_does_not_go_on_from_there(learner, trained):
    out, _ = trained
    before = (out / STATE_FILE).read_bytes()
    with pytest.raises(ValueError, match="of another configuration"):
        next(learner.training.train(learner.given, replace(learner.smoke, batch=31), out))
    assert (out / STATE_FILE).read_bytes() == before


def test_other_data_do_not_go_on_from_there(learner, trained):
    with pytest.raises(ValueError, match="of other demonstrations"):
        next(learner.training.train(learner.given[:1], learner.smoke, trained[0]))


def test_a_training_on_another_device_does_not_go_on_from_there(learner, trained, tmp_path):
    state = torch.load(trained[0] / STATE_FILE, weights_only=True)
    torch.save(state | {"device": "cuda"}, tmp_path / STATE_FILE)
    with pytest.raises(ValueError, match="was trained on another device"):
        next(learner.training.train(learner.given, learner.smoke, tmp_path))


@pytest.mark.parametrize(
    "damage", ["empty", *map(slow, ["cut off", "text"]), "of other weights", slow("of nothing")]
)
def test_what_is_no_state_of_the_training_is_refused_in_one_line(
    learner, trained, tmp_path, damage
):
    whole = (trained[0] / STATE_FILE).read_bytes()
    path = tmp_path / STATE_FILE
    if damage == "of other weights":
        state = torch.load(trained[0] / STATE_FILE, weights_only=True)
        torch.save(state | {"model": {"other": torch.zeros(1)}}, path)
    elif damage == "of nothing":
        torch.save({}, path)
    else:
        written = {"empty": b"", "cut off": whole[: len(whole) // 2], "text": b"weights"}
        path.write_bytes(written[damage])
    with pytest.raises(ValueError, match="cannot be continued") as refusal:
        next(learner.training.train(learner.given, learner.smoke, tmp_path))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("learner", "what"),
    [(name, what) for name, one in LEARNERS.items() for what in one.checkpoints.fits],
    indirect=["learner"],
)
def test_a_checkpoint_for_something_else_is_refused_in_one_line(
    learner, what, trained, tmp_path, monkeypatch
):
    model = learner.checkpoints.load(trained[0] / learner.training.CHECKPOINT_FILE)
    path = tmp_path / "other.safetensors"
    with monkeypatch.context() as patch:
        patch.setitem(learner.checkpoints.fits, what, 999)
        learner.checkpoints.save(path, model)
    with pytest.raises(CheckpointError, match=f"{what} 999, but here it is") as refusal:
        learner.checkpoints.load(path)
    assert "\n" not in str(refusal.value)


def test_a_checkpoint_of_another_learner_is_called_so(learner, trained):
    path = trained[0] / learner.training.CHECKPOINT_FILE
    for other in LEARNERS.values():
        if other is not learner:
            with pytest.raises(
                CheckpointError, match=f"no checkpoint of a {other.checkpoints.holds}"
            ):
                other.checkpoints.load(path)


@pytest.mark.parametrize(
    ("spoilt", "why"),
    [
        ({"config": {"newer": 1}}, "its configuration is of another version"),
        ({"config": [1]}, "no checkpoint of a"),
        ({"fits": [1]}, "no checkpoint of a"),
    ],
)
def test_a_checkpoint_of_another_form_is_refused_in_one_line(
    learner, trained, tmp_path, spoilt, why
):
    config = learner.checkpoints.config(trained[0] / learner.training.CHECKPOINT_FILE)
    said = {"config": asdict(config), "fits": dict(learner.checkpoints.fits)}
    for name, value in spoilt.items():
        said[name] = said[name] | value if isinstance(value, dict) else value
    path = tmp_path / "other.safetensors"
    save_file({}, path, {name: json.dumps(value) for name, value in said.items()})
    with pytest.raises(CheckpointError, match=why) as refusal:
        learner.checkpoints.load(path)
    assert "\n" not in str(refusal.value)
