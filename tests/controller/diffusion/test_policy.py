"""Laws of the policy: what is committed stays, and the graph is the network."""

import numpy as np
import pytest
import torch
from torch import Tensor

from controller.diffusion.config import PolicyConfig
from controller.diffusion.features import Features
from controller.diffusion.graph import Sampler
from controller.diffusion.policy import Policy
from controller.diffusion.tracker_noise import noised
from controller.diffusion.windows import Windows
from tests.controller.diffusion.demonstrated import demonstration
from tissue_sim.observation import VECTOR_SIZE, fields

CONFIG = PolicyConfig(condition_width=32, condition_blocks=1, denoiser_width=32, denoiser_blocks=1)


@pytest.fixture(scope="module")
def policy() -> Policy:
    torch.manual_seed(0)
    policy = Policy(CONFIG)
    seen = Windows([demonstration()], CONFIG).batch(torch.arange(100))
    policy.normalise_by(seen.history, seen.jaw_rad, seen.chunk)
    return policy.eval().requires_grad_(False)


@pytest.fixture(scope="module")
def inputs() -> dict[str, Tensor]:
    seen = Windows([demonstration(seed=1)], CONFIG).batch(torch.tensor([20]))
    generator = torch.Generator().manual_seed(0)
    return {
        "history": seen.history,
        "jaw_rad": seen.jaw_rad,
        "words": torch.randn(1, 384, generator=generator),
        "committed_chunk": seen.chunk,
        "n_committed": torch.tensor([3]),
        "noise": torch.randn(1, CONFIG.horizon, 20, generator=generator),
    }


def test_rows_committed_are_handed_back_and_decide_the_others(policy, inputs):
    chunk = policy(**inputs)
    given = inputs["committed_chunk"]
    torch.testing.assert_close(chunk[:, :3], given[:, :3], atol=1e-6, rtol=0)
    other = policy(**inputs | {"committed_chunk": given + 0.01})
    assert (other - chunk)[:, 3:].abs().max() > 1e-5


def test_rows_not_committed_have_no_say(policy, inputs):
    given = inputs["committed_chunk"].clone()
    given[:, 3:] += 1.0
    torch.testing.assert_close(policy(**inputs | {"committed_chunk": given}), policy(**inputs))


def test_words_and_what_is_seen_have_a_say(policy, inputs):
    chunk = policy(**inputs)
    for name in ("history", "jaw_rad", "words", "noise"):
        changed = inputs | {name: inputs[name] + 0.1}
        assert (policy(**changed) - chunk).abs().max() > 1e-5, name


def test_a_policy_that_says_nothing_holds_the_jaws_as_commanded(inputs):
    silent = Policy(CONFIG)
    for weights in silent.denoiser.leave.parameters():
        torch.nn.init.zeros_(weights)
    held = torch.tensor([[0.4, -0.3]])
    none = {"jaw_rad": held, "n_committed": torch.zeros(1, dtype=torch.int64)}
    chunk = silent(**inputs | none).view(1, CONFIG.horizon, 2, 10)
    torch.testing.assert_close(chunk[..., 9], held[:, None].expand(1, CONFIG.horizon, 2))
    assert not chunk[..., :9].any()


def test_the_exported_graph_is_the_network(policy, inputs):
    chunk = Sampler(policy)({name: value[0].numpy() for name, value in inputs.items()})
    np.testing.assert_allclose(chunk, policy(**inputs)[0].numpy(), atol=1e-5)


def test_the_loss_is_nothing_where_nothing_is_valid_or_all_is_committed(policy, inputs):
    condition = policy.condition(inputs["history"], inputs["jaw_rad"], inputs["words"])
    chunk, noise = inputs["committed_chunk"], inputs["noise"][:, None]
    level, n_committed = torch.full((1, 1), 0.5), torch.tensor([[4]])
    none, first = torch.zeros(1, 16, dtype=torch.bool), torch.arange(16)[None] < 4
    for valid in (none, first):
        assert (
            policy.loss(condition, inputs["jaw_rad"], chunk, valid, n_committed, level, noise)
            == 0.0
        )
    assert policy.loss(condition, inputs["jaw_rad"], chunk, ~none, n_committed, level, noise) > 0.0


def test_the_loss_does_not_look_at_rows_that_are_not_valid(policy, inputs):
    condition = policy.condition(inputs["history"], inputs["jaw_rad"], inputs["words"])
    noise, level = inputs["noise"][:, None], torch.ones(1, 1)  # noise alone: nothing shows through
    valid, n_committed = torch.arange(16)[None] < 8, torch.zeros(1, 1, dtype=torch.int64)
    chunk = inputs["committed_chunk"]
    changed = chunk.clone()
    changed[:, 8:] += 1.0
    losses = [
        policy.loss(condition, inputs["jaw_rad"], c, valid, n_committed, level, noise)
        for c in (chunk, changed)
    ]
    torch.testing.assert_close(*losses, rtol=1e-4, atol=0)


def test_features_do_not_depend_on_places_beyond_the_last_clip():
    history = torch.from_numpy(demonstration().states[None, :2]).clone()
    fields(history)["n_clips"][:] = 2.0
    moved = history.clone()
    fields(moved)["clips_m"][:, :, 2:] += 0.02
    features, jaw_rad = Features(), torch.zeros(1, 2)
    torch.testing.assert_close(features(moved, jaw_rad), features(history, jaw_rad))
    fields(moved)["clips_m"][:, :, 1] += 0.02
    assert (features(moved, jaw_rad) - features(history, jaw_rad)).abs().max() > 0.1


def test_tracker_noise_is_on_what_is_tracked_and_on_nothing_else():
    clean = torch.zeros(500, 1, VECTOR_SIZE)
    seen = fields(noised(clean, torch.Generator().manual_seed(0)))
    assert not clean.any()
    for name in ("n_clips", "clip_loaded", "scissors", "severed"):
        assert not seen[name].any()
    assert not seen["tips_endoscope"][..., :3].any()
    torch.testing.assert_close(seen["sac_m"].std(), torch.tensor(2e-4), rtol=0.05, atol=0)
