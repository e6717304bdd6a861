"""Tests of perception's training: it learns a picture, and fine-tuning keeps what it must keep."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
import torch

from controller.perception.checkpoint import CHECKPOINTS
from controller.perception.network import N_WIDE
from controller.perception.prior import fit_prior
from controller.perception.training import (
    PRESETS,
    VIEWS,
    WEIGHTS_FILE,
    join_views,
    train_view,
)
from planner.learning.optimise import fine_tuning
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.sensing.observation import N_LINE, N_POINTS, N_SHOWN, TUBE_POINTS, TUBE_ROWS

SMOKE = PRESETS["smoke"]
SIZE = (64, 96)  # height, width


def pictures(
    path: Path, seed: int, frames: int = 6, size: tuple[int, int] = SIZE, third: bool = True
) -> Path:
    """Write made-up labelled frames, in which every point is a white dot at its place."""
    rng = np.random.default_rng(seed)
    pixels = rng.uniform(8.0, min(size) - 8.0, (frames, N_SHOWN, 2)).astype(np.float32)
    rgb = np.zeros((frames, *size, 3), np.uint8)
    for k, frame in enumerate(pixels.astype(int)):
        rgb[k, frame[:, 1], frame[:, 0]] = 255
    columns = {
        "points_m": rng.normal(0.0, 0.01, (frames, N_POINTS, 3)).astype(np.float32),
        "there": np.ones((frames, N_SHOWN), bool),
        "severed": np.zeros((frames, len(TUBES)), bool),
        "third_tube": np.full(frames, float(third)),
        "radius_m": np.tile(0.0015 * np.array([1.0, 1.0, third]), (frames, 1)),
        "sac_radius_m": np.full((frames, 5), 0.01, np.float32),
    }
    for view in VIEWS:
        columns[f"rgb.{view}"] = rgb
        columns[f"pixels.{view}"] = pixels
        columns[f"visible.{view}"] = np.ones((frames, N_SHOWN), bool)
        columns[f"radius.{view}"] = np.full((frames, N_WIDE), 3.0, np.float32)
    np.savez(path, **columns)
    return path


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("perception")
    files = [pictures(folder / f"{seed}.npz", seed) for seed in (1, 2)]
    for view in VIEWS:
        assert len(list(train_view(files, view, SMOKE, folder / view))) == SMOKE.steps
    return join_views(files, SMOKE, folder)


def losses(files: list[Path], out: Path, steps: int) -> Iterator[float]:
    config = replace(SMOKE, steps=steps)
    return (step.loss for step in train_view(files, VIEWS[0], config, out))


def test_stopped_and_resumed_it_ends_at_the_same_weights(base: Path, tmp_path: Path) -> None:
    files = [pictures(tmp_path / f"{seed}.npz", seed) for seed in (1, 2)]
    _ = list(islice(train_view(files, VIEWS[0], SMOKE, tmp_path / VIEWS[0]), SMOKE.save_every + 1))
    rest = list(train_view(files, VIEWS[0], SMOKE, tmp_path / VIEWS[0]))
    assert [step.step for step in rest] == list(range(SMOKE.save_every + 1, SMOKE.steps + 1))
    expected, found = (
        torch.load(folder / VIEWS[0] / WEIGHTS_FILE, weights_only=True)
        for folder in (base.parent, tmp_path)
    )
    assert all(torch.equal(weight, expected[name]) for name, weight in found.items())


def no_zip(path: Path) -> None:
    with path.open("wb") as file:
        np.save(file, np.zeros(3))


def of_two_tubes(path: Path) -> None:
    """Leave the points of the third tube out, as an older version did."""
    with np.load(path) as file:
        columns = dict(file)
    rows = np.delete(np.arange(N_SHOWN), TUBE_ROWS["third"])
    columns["there"] = columns["there"][:, rows]
    np.savez(path, **columns)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda path: path.write_bytes(b""),
        lambda path: path.write_bytes(path.read_bytes()[:-100]),
        lambda path: path.write_text("no pictures"),
        lambda path: np.savez(path, header="a recording"),
        lambda path: pictures(path, 2, size=(32, 96)),
        no_zip,
        of_two_tubes,
    ],
    ids=["empty", "cut short", "text", "a recording", "smaller pictures", "one array", "two tubes"],
)
def test_a_file_without_labelled_frames_is_one_line(tmp_path: Path, spoil: Callable) -> None:
    files = [pictures(tmp_path / f"{seed}.npz", seed) for seed in (1, 2)]
    spoil(files[1])
    with pytest.raises(ValueError, match=re.escape(f"{files[1]}: ")) as refused:
        next(train_view(files, VIEWS[0], SMOKE, tmp_path))
    assert "\n" not in str(refused.value)


def test_the_loss_falls(tmp_path: Path) -> None:
    found = list(losses([pictures(tmp_path / "a.npz", 3)], tmp_path, 40))
    assert np.mean(found[-5:]) < 0.9 * np.mean(
        found[:5]
    )  # the dots are alike: where they lie is learnt


def test_other_frames_in_a_file_of_the_same_size_do_not_go_on_from_there(tmp_path: Path) -> None:
    path = pictures(tmp_path / "a.npz", 3)
    size = path.stat().st_size
    assert len(list(losses([path], tmp_path, 2))) == 2
    assert not list(losses([path], tmp_path, 2))  # nothing is left to do
    assert pictures(path, 4).stat().st_size == size
    with pytest.raises(ValueError, match="of other demonstrations"):
        list(losses([path], tmp_path, 2))


def test_fine_tuning_moves_the_networks_and_keeps_the_prior(base: Path, tmp_path: Path) -> None:
    before, files = CHECKPOINTS.load(base), [pictures(tmp_path / "b.npz", 4)]
    config, model = fine_tuning(CHECKPOINTS, SMOKE, base)
    for view in VIEWS:
        list(train_view(files, view, config, tmp_path / view, base=model))
    after = CHECKPOINTS.load(join_views(files, config, tmp_path, model))
    np.testing.assert_array_equal(after.prior().mean, before.prior().mean)
    np.testing.assert_array_equal(after.prior().spread, before.prior().spread)
    weights = [next(m.networks[VIEWS[0]].parameters()) for m in (before, after)]
    assert not (weights[0] == weights[1]).all()


def test_the_prior_places_a_third_tube_beside_the_others_where_few_patients_have_one(
    tmp_path: Path,
) -> None:
    """Check that patients without one neither draw its place to zero nor make it too certain."""
    third, usual = TUBE_ROWS["third"], slice(2 * TUBE_POINTS)
    having = pictures(tmp_path / "third.npz", 6, frames=40)
    others = [pictures(tmp_path / f"{k}.npz", k, frames=40, third=False) for k in range(3)]
    with np.load(having) as file:
        x = file["points_m"][:, :N_LINE].astype(float)
    off_m = x[:, third] - x[:, usual].mean(axis=1, keepdims=True)
    one, few = fit_prior([having]), fit_prior([having, *others])
    mean = few.mean.reshape(N_LINE, 3)
    np.testing.assert_allclose(mean[third] - mean[usual].mean(axis=0), off_m.mean(axis=0))
    rows = slice(3 * third.start, 3 * third.stop)
    ratio = np.diag(few.spread)[rows] / np.diag(one.spread)[rows]
    assert ((ratio > 0.7) & (ratio < 1.4)).all()
    assert np.linalg.eigvalsh(few.spread).min() > 0.0
    assert np.linalg.eigvalsh(fit_prior(others).spread).min() > 0.0
    np.testing.assert_allclose(few.radius_m, 0.0015, rtol=1e-6)


def test_a_new_perception_has_the_prior_of_its_patients(base: Path, tmp_path: Path) -> None:
    files = [pictures(tmp_path / "c.npz", 5)]
    for view in VIEWS:
        list(train_view(files, view, SMOKE, tmp_path / view))
    prior = CHECKPOINTS.load(join_views(files, SMOKE, tmp_path)).prior()
    with np.load(files[0]) as frames:
        mean = frames["points_m"][:, :N_LINE].astype(float).mean(axis=0)
    np.testing.assert_allclose(prior.mean, mean.ravel())
    assert not np.array_equal(prior.mean, CHECKPOINTS.load(base).prior().mean)
