"""Tests of the controller from pixels: what has an effect on it, and what it remembers."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from controller.dataset.schema import PICTURE_SHAPE
from controller.pixels.config import CAMERAS
from controller.pixels.controller import ControllerPixels, make
from controller.pixels.policy import CHECKPOINTS, PixelPolicy
from controller.pixels.training import PRESETS
from planner.instruction import Instruction
from planner.policy_setup import PolicySetup
from planner.procedure.cholecystectomy import TASKS
from tests.controller.diffusion.on_tube import seen
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.sensing.observation import (
    ENCODED,
    VECTOR_LAYOUT,
    Observation,
    fields,
    observation_of,
)

CONFIG = PRESETS["smoke"].policy
PICTURE = np.random.default_rng(0).integers(0, 256, PICTURE_SHAPE, np.uint8)
CLIP, CUT = Instruction(task=TASKS[1]), Instruction(task=TASKS[5])


@pytest.fixture(scope="module")
def policy() -> PixelPolicy:
    torch.manual_seed(0)
    policy = PixelPolicy(CONFIG)
    policy.chunk_deviation *= 1e-3
    return policy.eval().requires_grad_(False)


def moment(vector: np.ndarray | None = None, time_s: float = 1.0) -> Observation:
    shown = {CAMERAS[0]: PICTURE}
    return replace(observation_of(seen(0.006) if vector is None else vector, time_s), images=shown)


def played(policy: PixelPolicy, now: Observation, said: Instruction = CLIP) -> np.ndarray:
    return np.stack([a.vector() for a in ControllerPixels(policy).act(now, said)])


def test_it_plays_as_much_of_a_chunk_as_configured(policy):
    assert len(played(policy, moment())) == CONFIG.chunks.play < CONFIG.chunks.horizon


def test_pictures_and_words_have_an_effect(policy):
    chunk = played(policy, moment())
    dark = replace(moment(), images={CAMERAS[0]: PICTURE // 2})
    assert not np.allclose(played(policy, dark), chunk, atol=1e-7)
    assert not np.allclose(played(policy, moment(), CUT), chunk, atol=1e-7)


@pytest.mark.parametrize("name", VECTOR_LAYOUT)
def test_of_an_observation_it_reads_only_what_encoders_and_motor_currents_tell(policy, name):
    vector = seen(0.006).copy()
    fields(vector)[name][...] = 1.0 - fields(vector)[name]
    alike = np.array_equal(played(policy, moment(vector)), played(policy, moment()))
    assert alike == (name not in ENCODED)


def test_motions_that_were_dropped_are_no_part_of_the_past(policy):
    given = []

    class Listening(PixelPolicy):
        def forward(self, **told):
            given.append(told)
            return super().forward(**told)

    listening = Listening(CONFIG).eval()
    listening.load_state_dict(policy.state_dict())
    controller, n = ControllerPixels(listening), 3
    first = controller.act(moment(), CLIP)
    _ = controller.act(moment(time_s=1.0 + n * CONTROL_PERIOD_S), CUT)
    assert [int(told["n_past"]) for told in given] == [0, n]
    jaws = torch.as_tensor(first[n - 1].jaw_rad, dtype=torch.float32)
    torch.testing.assert_close(given[1]["jaw_rad"][0], jaws)
    controller.reset()
    _ = controller.act(moment(time_s=2.0), CLIP)
    assert int(given[2]["n_past"]) == 0


def test_a_camera_that_is_missing_is_named(policy, tmp_path):
    path = tmp_path / "policy.safetensors"
    CHECKPOINTS.save(path, policy)
    controller = make(PolicySetup(checkpoint=str(path), cameras=CAMERAS))
    assert controller.act(moment(), CLIP)
    with pytest.raises(ValueError, match=f"name {CAMERAS[0]} with --cameras"):
        make(PolicySetup(checkpoint=str(path)))


def test_without_a_checkpoint_it_says_how_to_make_one():
    with pytest.raises(ValueError, match="calot train pixels"):
        make(PolicySetup(cameras=CAMERAS))
