"""Tests of displaced tools: only free tools are displaced; chunks lead to the same places."""

import numpy as np
import pytest
import torch

from controller.action import hold
from controller.diffusion.chunk_frame import JAWS, actions_of
from controller.diffusion.config import PolicyConfig
from controller.diffusion.displacement import (
    ARRIVED,
    BACK_STEPS,
    DISPLACED_M,
    FREE_N,
    NARROWED,
    NEAR_M,
    OPEN_RAD,
    arrived,
    displaced,
    free_and_near,
    half_shut,
)
from controller.diffusion.windows import Batch, Windows
from controller.expert.motion import JAW_SPEED_RAD_S
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE, correction_from_text
from tests.controller.diffusion.demonstrated import demonstration
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.sensing.observation import fields

HORIZON = 40
LEFT, RIGHT = 0, 1


@pytest.fixture(scope="module")
def seen() -> Batch:
    """Return a batch: the right tool is at tissue, open and free; the left is closed or loaded."""
    windows = Windows([demonstration()], PolicyConfig(horizon=HORIZON))
    batch = windows.batch(torch.arange(len(windows)), torch.zeros(len(windows), dtype=torch.long))
    jaw, forces_n = (fields(batch.history)[name] for name in ("joints", "forces_n"))
    jaw, even = jaw[..., 6], torch.arange(len(windows)) % 2 == 0
    jaw[..., RIGHT], forces_n[..., RIGHT, 2] = 1.1 * OPEN_RAD, 0.9 * FREE_N
    jaw[even, :, LEFT], forces_n[even, :, LEFT, 2] = 0.9 * OPEN_RAD, 0.9 * FREE_N
    jaw[~even, :, LEFT], forces_n[~even, :1, LEFT, 2] = 1.1 * OPEN_RAD, 1.1 * FREE_N
    tip = fields(batch.history)["tips_endoscope"][..., 3]
    tip[:, :, RIGHT] = fields(batch.history)["tubes_m"][:, :, 0, 0]
    return flagged(batch)


def flagged(batch: Batch) -> Batch:
    """Return a batch with the flags that belong to its history."""
    flags = [free_and_near(frames.numpy()) for frames in batch.history.unbind(dim=1)]
    free, near = (torch.from_numpy(np.stack(flag, axis=1)) for flag in zip(*flags, strict=True))
    return batch._replace(free=free.all(dim=1), near=near[:, 0])


@pytest.fixture(scope="module")
def moved(seen: Batch) -> Batch:
    return displaced(seen, torch.Generator().manual_seed(0))


def tips_m(batch: Batch) -> torch.Tensor:
    return fields(batch.history)["tips_endoscope"][..., 3]  # (B, K, 2, 3)


def moves_m(batch: Batch) -> torch.Tensor:
    return batch.chunk.unflatten(-1, (2, -1))[..., :3]  # (B, H, 2, 3)


def test_free_tools_are_displaced_equally_in_every_frame_and_others_are_not(seen, moved):
    off_m = tips_m(moved) - tips_m(seen)
    torch.testing.assert_close(off_m, off_m[:, :1].expand_as(off_m), atol=1e-7, rtol=0.0)
    assert not off_m[:, :, LEFT].any()
    assert off_m[:, 0, RIGHT].std() == pytest.approx(DISPLACED_M, rel=0.2)


def test_no_tool_far_from_tissue_is_displaced(seen):
    history = seen.history.clone()
    for name in ("tubes_m", "sac_m"):
        fields(history)[name][..., 2] += 0.1 + NEAR_M
    far = displaced(flagged(seen._replace(history=history)), torch.Generator().manual_seed(0))
    assert torch.equal(far.history, history)
    assert torch.equal(far.chunk, seen.chunk)


def test_chunks_lead_to_the_same_places_as_without(seen, moved):
    off_m = (tips_m(moved) - tips_m(seen))[:, 0]
    left_over_m = off_m[:, None] + moves_m(moved) - moves_m(seen)
    for steps in (1, 4, HORIZON):
        share = torch.exp(torch.tensor(-steps / BACK_STEPS))
        torch.testing.assert_close(left_over_m[:, steps - 1], share * off_m, atol=1e-7, rtol=0.0)


def test_under_a_correction_the_chunk_goes_the_same_way_from_any_place(seen, moved):
    told = corrected(seen, "move right arm higher")
    led = displaced(told, torch.Generator().manual_seed(0))
    assert torch.equal(led.history, moved.history)
    assert torch.equal(led.chunk, seen.chunk)


@pytest.mark.parametrize(
    ("text", "row", "along"),
    [("move right arm higher", RIGHT, "higher"), ("move left arm to the left", LEFT, "left")],
)
def test_an_arm_that_has_gone_too_far_goes_back_by_it_with_the_jaws_as_commanded(
    seen, text, row, along
):
    told = corrected(seen, text)
    told = told._replace(left=torch.full_like(told.left, 0.004))
    ended = arrived(told, torch.Generator().manual_seed(0))
    done = (ended.left != told.left).any(dim=1)
    assert done.float().mean() == pytest.approx(ARRIVED, abs=0.1)
    assert (ended.left[done, 0] <= 0.0).all()
    assert (ended.left[:, 1] == told.left[:, 1]).all()
    assert ended.valid[done].all()
    rests = hold(ended.jaw_rad[done][0].numpy()).vector().reshape(2, 10)
    motions = actions_of(ended.chunk[done][0].numpy()).reshape(-1, 2, 10)
    gone_m = motions[..., :3].sum(axis=0)
    gone = 1.0 - np.exp(-len(motions) / BACK_STEPS)
    back_m = gone * ended.left[done][0, 0].item() * np.array(DIRECTION_ENDOSCOPE[along])
    np.testing.assert_allclose(gone_m[row], back_m, atol=1e-6)
    np.testing.assert_allclose(gone_m[1 - row], 0.0, atol=1e-9)
    np.testing.assert_allclose(
        motions[..., 3:], np.broadcast_to(rests[:, 3:], (len(motions), 2, 7)), atol=1e-6
    )
    assert torch.equal(ended.chunk[~done], told.chunk[~done])
    assert torch.equal(arrived(seen, torch.Generator().manual_seed(0)).chunk, seen.chunk)


def test_nothing_else_is_changed_and_the_input_stays_as_it_was(seen, moved):
    before, after = seen.history.clone(), moved.history.clone()
    for history in (before, after):
        fields(history)["tips_endoscope"][..., 3] = 0.0
    assert torch.equal(before, after)
    assert torch.equal(moves_m(seen)[:, :, LEFT], moves_m(moved)[:, :, LEFT])
    assert torch.equal(seen.chunk[..., 13:], moved.chunk[..., 13:])
    for name in ("jaw_rad", "task", "correction", "left", "past", "n_past", "delay", "valid"):
        assert getattr(seen, name) is getattr(moved, name)
    again = displaced(seen, torch.Generator().manual_seed(0))
    assert torch.equal(again.history, moved.history)
    assert torch.equal(again.chunk, moved.chunk)


WIDE_RAD = 0.8
SLOW_RAD = CONTROL_PERIOD_S * JAW_SPEED_RAD_S


@pytest.fixture(scope="module")
def clear(seen: Batch) -> Batch:
    """Return a batch in which both tools are wide open and only the left is clear of tissue."""
    history, chunk, past = seen.history.clone(), seen.chunk.clone(), seen.past.clone()
    parts = fields(history)
    parts["joints"][..., 6], parts["forces_n"][:] = WIDE_RAD, 0.0
    parts["tips_endoscope"][:, :, LEFT, :, 3] = parts["tubes_m"][:, :, 0, 0]
    parts["tips_endoscope"][:, :, LEFT, 2, 3] += 0.1 + NEAR_M
    chunk[..., JAWS] = past[..., JAWS] = WIDE_RAD
    jaw_rad = torch.full_like(seen.jaw_rad, WIDE_RAD)
    return flagged(seen._replace(history=history, chunk=chunk, past=past, jaw_rad=jaw_rad))


@pytest.fixture(scope="module")
def narrowed(clear: Batch) -> Batch:
    return half_shut(clear, torch.Generator().manual_seed(0))


def corrected(batch: Batch, text: str) -> Batch:
    row = CORRECTIONS.index(correction_from_text(text))
    return batch._replace(correction=torch.full_like(batch.correction, row))


def test_some_tools_clear_of_tissue_have_half_shut_jaws_in_every_frame(clear, narrowed):
    jaw_rad = narrowed.jaw_rad[:, LEFT]
    changed = jaw_rad < WIDE_RAD
    assert changed.float().mean() == pytest.approx(NARROWED, abs=0.15)
    assert jaw_rad.min() >= OPEN_RAD
    assert jaw_rad[changed].std() > 0.1
    measured = fields(narrowed.history)["joints"][:, :, LEFT, 6]
    torch.testing.assert_close(measured, jaw_rad[:, None].expand_as(measured))
    before = narrowed.past[..., JAWS][..., LEFT]
    torch.testing.assert_close(before, jaw_rad[:, None].expand_as(before))


def test_half_shut_jaws_open_as_fast_as_the_expert_opens_them_and_no_wider(clear, narrowed):
    jaws_rad = narrowed.chunk[..., JAWS][..., LEFT]
    rows = torch.arange(1, jaws_rad.shape[1] + 1)
    way_rad = narrowed.jaw_rad[:, LEFT, None] + SLOW_RAD * rows
    torch.testing.assert_close(jaws_rad, way_rad.clamp(max=WIDE_RAD))
    assert (jaws_rad[:, -1] == WIDE_RAD).all()


def test_jaws_that_close_are_not_opened_further(clear):
    shut = clear._replace(chunk=clear.chunk.clone())
    shut.chunk[..., JAWS] = 0.0
    out = half_shut(shut, torch.Generator().manual_seed(0))
    assert torch.equal(out.chunk, shut.chunk)


def test_jaws_at_tissue_or_closed_or_excluded_are_not_changed(clear, narrowed):
    assert torch.equal(narrowed.jaw_rad[:, RIGHT], clear.jaw_rad[:, RIGHT])
    assert torch.equal(narrowed.chunk[..., 10:], clear.chunk[..., 10:])
    told = corrected(clear, "open both grippers")
    for before, after in zip(told, half_shut(told, torch.Generator().manual_seed(0)), strict=True):
        assert torch.equal(before, after)
    history = clear.history.clone()
    fields(history)["joints"][:, -1, LEFT, 6] = 0.9 * OPEN_RAD
    shut = flagged(clear._replace(history=history))
    assert torch.equal(half_shut(shut, torch.Generator().manual_seed(0)).jaw_rad, shut.jaw_rad)


def test_nothing_but_the_jaws_is_changed(clear, narrowed):
    before, after = clear.history.clone(), narrowed.history.clone()
    for history in (before, after):
        fields(history)["joints"][..., 6] = 0.0
    assert torch.equal(before, after)
    assert torch.equal(moves_m(clear), moves_m(narrowed))
