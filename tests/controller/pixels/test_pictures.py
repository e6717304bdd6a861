"""Tests of how pictures are made smaller, and shifted in training."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from controller.dataset.schema import PICTURE_SHAPE
from controller.pixels.config import CHUNKS, PixelConfig
from controller.pixels.training import PRESETS, SHIFT_PX, FilmData, shifted, train
from tests.controller.pixels.filmed import film


@given(shrink=st.sampled_from([1, 2, 4, 8]), seed=st.integers(0, 1000))
def test_a_pixel_of_a_shrunk_picture_is_the_mean_of_its_square(shrink, seed):
    picture = np.random.default_rng(seed).integers(0, 256, (16, 24, 3), np.uint8)
    small = PixelConfig(shrink=shrink).shrunk(picture)
    for row, column in np.ndindex(small.shape[:2]):
        square = picture[row * shrink :, column * shrink :][:shrink, :shrink]
        np.testing.assert_allclose(small[row, column], square.mean(axis=(0, 1)), atol=0.5)


def test_what_cannot_be_shrunk_or_seen_is_refused():
    with pytest.raises(ValueError, match="shrink must divide"):
        PixelConfig(shrink=7)
    with pytest.raises(ValueError, match="at least one"):
        PixelConfig(cameras=())
    with pytest.raises(ValueError, match="history"):
        PixelConfig(chunks=type(CHUNKS)())


def test_all_cameras_of_a_window_are_shifted_alike_and_the_edge_repeats():
    chance = torch.Generator().manual_seed(0)
    row, column = torch.meshgrid(torch.arange(20), torch.arange(30), indexing="ij")
    picture = torch.stack([row, column, row], dim=-1).to(torch.uint8)
    before = picture.expand(50, 2, 20, 30, 3)
    after = shifted(before, chance).int()
    assert torch.equal(after[:, 0], after[:, 1])
    down, along = after[:, 0, 10, 15, 0] - 10, after[:, 0, 10, 15, 1] - 15
    assert down.unique().tolist() == along.unique().tolist() == [*range(-SHIFT_PX, SHIFT_PX + 1)]
    expected = (row + down[:, None, None]).clamp(0, 19)
    assert torch.equal(after[:, 0, :, :, 0], expected)


def test_each_window_has_the_picture_of_its_own_moment():
    films = [film(seed, n=40 + seed) for seed in range(3)]
    data = FilmData(films, replace(PRESETS["smoke"], policy=PixelConfig()), "cpu")
    every = torch.arange(len(data.windows))
    newest = data.windows.batch(every, torch.zeros_like(every)).newest
    joined = torch.from_numpy(np.concatenate([f.pictures for f in films]))
    assert set(newest.tolist()) > {0, 40, 81}
    assert torch.equal(data.shown(newest), joined[newest])


def test_training_does_not_go_on_with_other_pictures_of_the_same_motions(tmp_path):
    config, films = replace(PRESETS["smoke"], steps=1), [film(seed) for seed in range(2)]
    assert len(list(train(films, config, tmp_path))) == 1
    assert not list(train(films, config, tmp_path))  # nothing is left to do
    films[1].pictures[7, 0, 3, 4, 0] ^= 1
    with pytest.raises(ValueError, match="of other demonstrations"):
        list(train(films, config, tmp_path))


def test_the_size_in_datasets_can_be_shrunk_by_the_default():
    small = PixelConfig().shrunk(np.full(PICTURE_SHAPE, 255, np.uint8))
    assert small.shape == (120, 160, 3)
    assert (small == 255).all()
