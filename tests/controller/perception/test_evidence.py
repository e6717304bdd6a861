"""Laws of evidence: cells near a clip say where it is, and training teaches them to."""

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from controller.perception.evidence import find
from controller.perception.graph import Shown
from controller.perception.network import FLAGS, STRIDE
from controller.perception.training import GROUPS, _offset_loss
from tissue_sim.frames import pose
from tissue_sim.sensing.glance import Picture
from tissue_sim.sensing.observation import N_LINE, N_POINTS

SIDE = 32  # cells
TURNED = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], float)
PICTURE = Picture(
    rgb=np.zeros((STRIDE * SIDE, STRIDE * SIDE, 3), np.uint8),
    T_endoscope_camera=pose(TURNED, np.array([0.0, 0.0, -0.1])),
    focal_px=200.0,
)
MIDDLES = STRIDE * (np.arange(SIDE) + 0.5)


def shown(clip_px: np.ndarray) -> Shown:
    """Return maps whose cells near a clip are sure of it and say exactly where it is."""
    cells = np.stack(np.meshgrid(MIDDLES, MIDDLES))
    off = clip_px[:, None, None] - cells
    dense = np.full((2, SIDE, SIDE), -6.0)
    dense[0] += 12.0 * (np.hypot(*off) < 6.0)
    line = np.zeros(N_LINE)
    return Shown(
        pixels=np.zeros((N_LINE, 2)), log_sigma=line, inside=line, visible=line, log_radius=line,
        dense=dense, offset=np.stack([off, off]), flags=np.zeros(len(FLAGS)),
    )  # fmt: skip


@given(column=st.floats(40.0, 88.0), row=st.floats(40.0, 88.0), off=st.floats(-5.0, 5.0))
def test_a_clip_is_found_where_cells_say_and_not_at_their_middles(column, row, off):
    """Look for it some pixels beside its place."""
    clip_px = np.array([column, row])
    believed_px = clip_px + np.array([off, -0.5 * off])
    camera = np.array([0.0, 0.0, -0.1])
    across = (believed_px - 0.5 * STRIDE * SIDE) * 0.1 / PICTURE.focal_px
    place = camera + TURNED @ np.array([0.1, -across[0], -across[1]])
    (pixel,), _ = PICTURE.project(place[None])
    assert pixel == pytest.approx(believed_px, abs=1e-6)
    assert find("clip", shown(clip_px), PICTURE, place) == pytest.approx(clip_px, abs=1e-9)


def test_the_loss_of_offsets_is_zero_for_the_nearest_clip_alone():
    """The second clip is not shown, and lies nearer to the cells."""
    pixels = torch.full((1, N_POINTS + 4, 2), -1e4)
    pixels[0, GROUPS[0].start] = torch.tensor([50.0, 61.0])
    pixels[0, GROUPS[0].start + 1] = torch.tensor([51.0, 61.0])
    seen = torch.zeros(1, N_POINTS + 4, dtype=torch.bool)
    seen[0, GROUPS[0].start] = True
    cells = torch.stack(torch.meshgrid(*(2 * [torch.from_numpy(MIDDLES)]), indexing="xy"))
    right = torch.tensor([50.0, 61.0])[:, None, None] - cells.float()
    offset = torch.stack([right, torch.zeros_like(right)])[None]
    assert float(_offset_loss(offset, pixels, seen)) == pytest.approx(0.0, abs=1e-9)
    assert float(_offset_loss(offset + 1.0, pixels, seen)) == pytest.approx(2 * 0.85, abs=0.01)
