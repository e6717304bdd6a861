"""Laws of displaced tools: what a tool holds stays with it; chunks lead back to where they led."""

import pytest
import torch

from controller.diffusion.config import PolicyConfig
from controller.diffusion.displacement import (
    BACK_STEPS,
    DISPLACED_M,
    FREE_N,
    NEAR_M,
    OPEN_RAD,
    displaced,
)
from controller.diffusion.windows import Batch, Windows
from tests.controller.diffusion.demonstrated import demonstration
from tissue_sim.observation import fields

HORIZON = 40
LEFT, RIGHT = 0, 1


@pytest.fixture(scope="module")
def seen() -> Batch:
    """The right tool is at tissue, open and free; the left one is closed or feels something."""
    windows = Windows([demonstration()], PolicyConfig(horizon=HORIZON))
    batch = windows.batch(torch.arange(len(windows)), torch.zeros(len(windows), dtype=torch.long))
    jaw, forces_n = (fields(batch.history)[name] for name in ("joints", "forces_n"))
    jaw, even = jaw[..., 6], torch.arange(len(windows)) % 2 == 0
    jaw[..., RIGHT], forces_n[..., RIGHT, 2] = 1.1 * OPEN_RAD, 0.9 * FREE_N
    jaw[even, :, LEFT], forces_n[even, :, LEFT, 2] = 0.9 * OPEN_RAD, 0.9 * FREE_N
    jaw[~even, :, LEFT], forces_n[~even, :1, LEFT, 2] = 1.1 * OPEN_RAD, 1.1 * FREE_N
    tip = fields(batch.history)["tips_endoscope"][..., 3]
    tip[:, :, RIGHT] = fields(batch.history)["left_tube_m"][:, :, 0]
    return batch


@pytest.fixture(scope="module")
def moved(seen: Batch) -> Batch:
    return displaced(seen, torch.Generator().manual_seed(0))


def tips_m(batch: Batch) -> torch.Tensor:
    return fields(batch.history)["tips_endoscope"][..., 3]  # (B, K, 2, 3)


def moves_m(batch: Batch) -> torch.Tensor:
    return batch.chunk.unflatten(-1, (2, -1))[..., :3]  # (B, H, 2, 3)


def test_free_tools_stand_off_by_as_much_in_every_frame_and_no_other_does(seen, moved):
    off_m = tips_m(moved) - tips_m(seen)
    torch.testing.assert_close(off_m, off_m[:, :1].expand_as(off_m), atol=1e-7, rtol=0.0)
    assert not off_m[:, :, LEFT].any()
    assert off_m[:, 0, RIGHT].std() == pytest.approx(DISPLACED_M, rel=0.2)


def test_no_tool_far_from_tissue_stands_off(seen):
    history = seen.history.clone()
    for name in ("left_tube_m", "right_tube_m", "sac_m"):
        fields(history)[name][..., 2] += 0.1 + NEAR_M
    far = displaced(seen._replace(history=history), torch.Generator().manual_seed(0))
    assert torch.equal(far.history, history)
    assert torch.equal(far.chunk, seen.chunk)


def test_chunks_lead_to_where_they_led_without(seen, moved):
    off_m = (tips_m(moved) - tips_m(seen))[:, 0]
    left_over_m = off_m[:, None] + moves_m(moved) - moves_m(seen)
    for steps in (1, 4, HORIZON):
        share = torch.exp(torch.tensor(-steps / BACK_STEPS))
        torch.testing.assert_close(left_over_m[:, steps - 1], share * off_m, atol=1e-7, rtol=0.0)


def test_nothing_else_is_changed_and_what_is_seen_remains_as_it_was(seen, moved):
    before, after = seen.history.clone(), moved.history.clone()
    for history in (before, after):
        fields(history)["tips_endoscope"][..., 3] = 0.0
    assert torch.equal(before, after)
    assert torch.equal(moves_m(seen)[:, :, LEFT], moves_m(moved)[:, :, LEFT])
    assert torch.equal(seen.chunk[..., 13:], moved.chunk[..., 13:])
    for name in ("jaw_rad", "text", "past", "n_past", "delay", "valid"):
        assert getattr(seen, name) is getattr(moved, name)
    again = displaced(seen, torch.Generator().manual_seed(0))
    assert torch.equal(again.history, moved.history)
    assert torch.equal(again.chunk, moved.chunk)
