"""Tests of the policy: which inputs have an effect, and the graph equals the network."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor

from controller.dataset.schema import UNNAMED
from controller.diffusion.command import NONE, TOKEN_SIZE, encoded, sentences
from controller.diffusion.config import PolicyConfig
from controller.diffusion.graph import Sampler
from controller.diffusion.policy import Policy
from controller.diffusion.scene.features import Features
from controller.diffusion.windows import Batch, Windows
from planner.correction import CORRECTIONS
from planner.instruction import TASKS, Instruction
from tests.controller.diffusion.demonstrated import demonstration
from tissue_sim.sensing.observation import fields

CONFIG = PolicyConfig(condition_width=32, condition_blocks=1, denoiser_width=32, denoiser_blocks=1)


@pytest.fixture(scope="module")
def policy() -> Policy:
    torch.manual_seed(0)
    policy = Policy(CONFIG)
    which = torch.arange(100)
    seen = Windows([demonstration()], CONFIG).batch(which, torch.zeros_like(which))
    policy.normalise_by(policy.features(seen.history, seen.jaw_rad), seen)
    return policy.eval().requires_grad_(False)


@pytest.fixture(scope="module")
def seen() -> Batch:
    return Windows([demonstration(seed=1)], CONFIG).batch(torch.tensor([20]), torch.tensor([3]))


@pytest.fixture(scope="module")
def inputs(seen) -> dict[str, Tensor]:
    generator = torch.Generator().manual_seed(0)
    return {
        "history": seen.history,
        "jaw_rad": seen.jaw_rad,
        "words": torch.randn(1, 2, 384, generator=generator),
        "token": torch.randn(1, TOKEN_SIZE, generator=generator),
        "past": seen.past,
        "n_past": seen.n_past,
        "delay": seen.delay,
        "noise": torch.randn(1, CONFIG.horizon, 20, generator=generator),
    }


def loss(policy: Policy, seen: Batch, level: Tensor, noise: Tensor, *, kept: float = 1.0) -> Tensor:
    features, said = policy.features(seen.history, seen.jaw_rad), sentences(CONFIG)
    return policy.loss(features, seen, said, torch.full((len(seen.task), 1), kept), level, noise)


def test_only_the_known_past_has_an_effect(policy, inputs):
    known = inputs | {"n_past": torch.tensor([2])}
    for row in range(CONFIG.past):
        other = inputs["past"].clone()
        other[:, row] += 0.01
        change = (policy(**known | {"past": other}) - policy(**known)).abs().max()
        assert change > 1e-5 if row >= CONFIG.past - 2 else change == 0.0


def test_commands_and_observations_have_an_effect(policy, inputs):
    chunk = policy(**inputs)
    for name in ("history", "jaw_rad", "words", "token", "delay", "noise"):
        by = 1 if name == "delay" else 0.1
        changed = inputs | {name: inputs[name] + by}
        assert (policy(**changed) - chunk).abs().max() > 1e-5, name


def test_a_policy_that_says_nothing_holds_the_jaws_as_commanded(inputs):
    silent = Policy(CONFIG)
    for weights in silent.denoiser.leave.parameters():
        torch.nn.init.zeros_(weights)
    held = torch.tensor([[0.4, -0.3]])
    chunk = silent(**inputs | {"jaw_rad": held}).view(1, CONFIG.horizon, 2, 10)
    torch.testing.assert_close(chunk[..., 9], held[:, None].expand(1, CONFIG.horizon, 2))
    assert not chunk[..., :9].any()


def test_the_exported_graph_is_the_network(policy, inputs):
    chunk = Sampler(policy)({name: value[0].numpy() for name, value in inputs.items()})
    np.testing.assert_allclose(chunk, policy(**inputs)[0].numpy(), atol=1e-5)


def test_the_loss_does_not_look_at_rows_that_are_not_valid(policy, seen, inputs):
    noise, level = inputs["noise"][:, None], torch.ones(1, 1)  # noise alone, no chunk
    first = torch.arange(CONFIG.horizon)[None] < 8
    losses = []
    for valid in (first, torch.ones_like(first)):
        changed = seen.chunk + 0.1 * ~first[..., None]
        losses += [
            loss(policy, seen._replace(chunk=c, valid=valid), level, noise)
            for c in (seen.chunk, changed)
        ]
    torch.testing.assert_close(losses[0], losses[1], rtol=1e-4, atol=0)
    assert losses[3] > 1.01 * losses[2]


def test_a_window_is_trained_under_the_command_that_a_controller_gets(policy, seen):
    """The loss of noise alone is the distance from the chunk sampled in one step."""
    one_step = Policy(replace(CONFIG, sampling_steps=1))
    one_step.load_state_dict(policy.state_dict())
    noise, level = torch.randn(1, 1, CONFIG.horizon, 20), torch.ones(1, 1)
    for task, correction, left_m in ((3, 2, 0.005), (3, 2, 0.001), (3, 4, 0.005), (7, None, None)):
        said = Instruction(
            task=TASKS[task],
            correction=None if correction is None else CORRECTIONS[correction],
            left_m=left_m,
        )
        inputs = {name: part[None] for name, part in encoded(said, CONFIG).items()}
        given = {"history": seen.history, "jaw_rad": seen.jaw_rad, "past": seen.past}
        given |= {"n_past": seen.n_past, "delay": seen.delay, "noise": noise[:, 0]}
        heard = seen._replace(
            chunk=one_step(**given, **inputs),
            task=torch.tensor([task]),
            correction=torch.tensor([NONE if correction is None else correction]),
            left=torch.tensor([[UNNAMED if left_m is None else left_m, UNNAMED]]),
            valid=torch.ones_like(seen.valid),
        )
        assert loss(policy, heard, level, noise) < 1e-9
        assert loss(policy, heard, level, noise, kept=0.0) > 1e-8


def test_guidance_goes_beyond_the_command_away_from_none(policy, inputs):
    guided = Policy(replace(CONFIG, sampling_steps=1, guidance=0.5))
    plain = Policy(replace(CONFIG, sampling_steps=1))
    for other in (guided, plain):
        other.load_state_dict(policy.state_dict())
    nothing = {name: torch.zeros_like(inputs[name]) for name in ("words", "token")}
    commanded, none = plain(**inputs), plain(**inputs | nothing)
    torch.testing.assert_close(guided(**inputs), commanded + 0.5 * (commanded - none))


def test_features_do_not_depend_on_places_beyond_the_last_clip():
    history = torch.from_numpy(demonstration().states[None, :2]).clone()
    fields(history)["n_clips"][:] = 2.0
    moved = history.clone()
    fields(moved)["clips_m"][:, :, 2:] += 0.02
    features, jaw_rad = Features(), torch.zeros(1, 2)
    torch.testing.assert_close(features(moved, jaw_rad), features(history, jaw_rad))
    fields(moved)["clips_m"][:, :, 1] += 0.02
    assert (features(moved, jaw_rad) - features(history, jaw_rad)).abs().max() > 0.1
