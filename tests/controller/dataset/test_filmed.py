"""Tests of datasets with pictures: whole stretches of the expert, each with its own pictures."""

import json
import re

import numpy as np
import pyarrow.parquet as pq
import pytest

from controller.dataset import layout
from controller.dataset.card import CARD_PATH
from controller.dataset.filmed import read_filmed
from controller.dataset.merge import merge
from controller.dataset.part import header_of, read_part, video_path
from controller.dataset.reader import read_episodes
from controller.dataset.schema import ENCODED_SIZE, FPS, PICTURE_SHAPE, PICTURES, STATE, TISSUE
from controller.dataset.videos import pictures
from tests.controller.dataset.episodes import frame_of, grey, random_episode, write_parts
from tissue_sim.rendering.video import Video

CAMERAS = ("endoscope_left", "wrist_right")
SEEDS = (3, 4)


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """Return the root of a dataset of two parts, and the paths of these."""
    root = tmp_path_factory.mktemp("filmed")
    parts = write_parts(root / "parts", SEEDS, cameras=CAMERAS)
    merge(parts, root)
    return root, parts


def test_each_stretch_that_the_expert_led_is_an_episode_from_its_own_first_frame(filmed):
    root, parts = filmed
    expected = [(part, stretch) for part in map(read_part, parts) for stretch in part.stretches()]
    found = list(read_episodes(root))
    assert len(found) == len(expected) > len(SEEDS)
    for episode, (part, stretch) in zip(found, expected, strict=True):
        assert episode.columns["expert"].all()
        assert len(set(episode.columns["segment"].tolist())) == 1
        np.testing.assert_array_equal(episode.columns["action"], part.columns["action"][stretch])
        np.testing.assert_array_equal(episode.columns["frame_index"], np.arange(len(episode)))
        np.testing.assert_allclose(episode.columns["timestamp"] * FPS, np.arange(len(episode)))


def test_a_video_shows_an_episodes_frames_from_the_time_in_its_row(filmed):
    root, parts = filmed
    stretches = [s for part in map(read_part, parts) for s in part.stretches()]
    rows = pq.read_table(root / layout.EPISODES_PATH).to_pylist()
    for row, stretch in zip(rows, stretches, strict=True):
        for camera in CAMERAS:
            place = {name: row[f"videos/{PICTURES}{camera}/{name}"] for name in _PLACE}
            file = layout.FILES_A_CHUNK * place["chunk_index"] + place["file_index"]
            shown = list(pictures(root / layout.video_path(camera, file)))
            first, end = (round(place[f"{which}_timestamp"] * FPS) for which in ("from", "to"))
            assert [frame_of(p) for p in shown[first:end]] == list(range(*_bounds(stretch)))


def test_episodes_are_read_with_the_pictures_of_their_frames(filmed):
    root, parts = filmed
    expected = [_bounds(stretch) for part in map(read_part, parts) for stretch in part.stretches()]
    read = list(read_filmed(root, ("action",), CAMERAS[::-1], lambda p: p[:2, :3]))
    assert len(read) == len(expected)
    for (episode, shown), (first, end) in zip(read, expected, strict=True):
        assert shown.shape == (len(episode), len(CAMERAS), 2, 3, 3)
        for camera in range(len(CAMERAS)):
            assert [frame_of(p) for p in shown[:, camera]] == list(range(first, end))


def test_a_camera_that_did_not_film_is_refused(filmed):
    with pytest.raises(ValueError, match="wrist_left did not film; cameras are: endoscope_left"):
        next(read_filmed(filmed[0], ("action",), ("wrist_left",), lambda p: p))


@pytest.mark.parametrize(
    "spoil",
    [
        lambda path: path.unlink(),
        lambda path: path.write_bytes(path.read_bytes()[:-100]),
        lambda path: pq.write_table(pq.read_table(path).drop_columns(["kind"]), path),
        lambda path: pq.write_table(pq.read_table(path).drop_columns([_CHUNK]), path),
    ],
    ids=["missing", "cut short", "without kinds", "without videos"],
)
def test_a_spoilt_table_of_episodes_is_one_line(tmp_path, spoil):
    merge(write_parts(tmp_path / "parts", (3,), cameras=CAMERAS), tmp_path)
    path = tmp_path / layout.EPISODES_PATH
    spoil(path)
    with pytest.raises(ValueError, match=re.escape(str(path))) as refused:
        next(read_filmed(tmp_path, ("action",), CAMERAS, lambda p: p))
    assert "\n" not in str(refused.value)


_CHUNK = f"videos/{PICTURES}{CAMERAS[0]}/chunk_index"
_PLACE = ("chunk_index", "file_index", "from_timestamp", "to_timestamp")


def _bounds(stretch):
    return stretch.start, stretch.stop


def test_the_robots_state_is_what_encoders_tell_and_the_tissue_is_left_to_the_pictures(filmed):
    root, _ = filmed
    described = json.loads((root / layout.INFO_PATH).read_text())
    assert described["features"][STATE]["shape"] == [ENCODED_SIZE]
    assert TISSUE not in described["features"]
    assert {PICTURES + camera for camera in CAMERAS} < set(described["features"])
    assert described["video_path"] == layout.VIDEO_PATH


LED = {3: [(0, 35), (40, 50)], 4: [], 5: [(10, 50)]}  # seed to stretches that the expert led
COLOURS = {3: [(40, 90, 60), (160, 80, 130)], 5: [(100, 120, 200)]}  # of each stretch's pictures


@pytest.fixture(scope="module")
def coloured(tmp_path_factory):
    """Return the root of a dataset whose stretches are each of a colour; other frames are white."""
    root, parts = tmp_path_factory.mktemp("coloured"), []
    for seed, stretches in LED.items():
        expert, shown = np.zeros(50, bool), np.full((50, 3), 255, np.uint8)
        for (first, end), colour in zip(stretches, COLOURS.get(seed, ()), strict=True):
            expert[first:end], shown[first:end] = True, colour
        options = {"cameras": CAMERAS, "expert": expert, "segment": np.zeros(50, int)}
        parts += write_parts(root / "parts", (seed,), **options)
        for k, camera in enumerate(CAMERAS):
            with Video(video_path(parts[-1], camera), keyframes=2) as video:
                for colour in np.roll(shown, k, axis=1):
                    video.add(np.broadcast_to(colour, PICTURE_SHAPE))
    merge(parts, root)
    return root


@pytest.mark.parametrize("camera", CAMERAS)
def test_statistics_of_pictures_are_of_the_episodes_own_frames(coloured, camera):
    rows = pq.read_table(coloured / layout.EPISODES_PATH).to_pylist()
    colours = [np.roll(c, CAMERAS.index(camera)) / 255.0 for c in (*COLOURS[3], *COLOURS[5])]
    for row, colour in zip(rows, colours, strict=True):
        for key in ("min", "max", "mean"):
            found = row[f"stats/{PICTURES}{camera}/{key}"]
            np.testing.assert_allclose(found, colour, atol=0.02)
    whole = json.loads((coloured / layout.STATS_PATH).read_text())[PICTURES + camera]
    mean = np.average(colours, axis=0, weights=[2, 1, 2])  # each thirtieth picture counts
    expected = {"min": np.min(colours, axis=0), "max": np.max(colours, axis=0), "mean": mean}
    for key, value in expected.items():
        np.testing.assert_allclose(np.reshape(whole[key], 3), value, atol=0.02)
        assert np.shape(whole[key]) == (3, 1, 1)


def test_videos_are_those_of_the_parts_with_an_episode(coloured):
    for k, camera in enumerate(CAMERAS):
        there = sorted((coloured / "videos" / f"{PICTURES}{camera}").glob("*/*"))
        assert there == [coloured / layout.video_path(camera, file) for file in range(2)]
        read = read_filmed(coloured, ("action",), (camera,), lambda p: p[:2, :3])
        means = [shown.mean(axis=(0, 1, 2, 3)) for _, shown in read]
        colours = np.roll([*COLOURS[3], *COLOURS[5]], k, axis=1)
        np.testing.assert_allclose(means, colours, atol=5.0)


def test_the_card_says_what_is_in_it(filmed):
    root, _ = filmed
    card = (root / CARD_PATH).read_text()
    assert ", ".join(CAMERAS) in card
    assert "2 patients (seeds 3 to 4)" in card


def test_the_card_of_a_later_dataset_replaces_it_but_no_other_file(tmp_path):
    parts = write_parts(tmp_path / "parts", (3, 4))
    merge(parts[:1], tmp_path)
    merge(parts, tmp_path)
    assert "2 patients" in (tmp_path / CARD_PATH).read_text()
    (tmp_path / CARD_PATH).write_text("mine")
    merge(parts, tmp_path)
    assert (tmp_path / CARD_PATH).read_text() == "mine"


def test_parts_of_other_cameras_do_not_mix_and_the_old_dataset_stays(tmp_path):
    parts = write_parts(tmp_path / "parts", (3,), cameras=CAMERAS)
    merge(parts, tmp_path)
    other = write_parts(tmp_path / "parts", (4,), cameras=CAMERAS[:1])
    assert [tuple(header_of(part).cameras) for part in (*parts, *other)] == [CAMERAS, CAMERAS[:1]]
    with pytest.raises(ValueError, match=re.escape(f"{other[0]}: its cameras are")):
        merge([*parts, *other], tmp_path)
    assert list(read_episodes(tmp_path))


def cut_short(path):
    with Video(path) as video:
        for frame in range(49):
            video.add(grey(frame))


@pytest.mark.parametrize(
    "spoil", [lambda p: p.unlink(), lambda p: p.write_bytes(b"no video"), cut_short]
)
def test_a_video_that_is_missing_or_damaged_is_one_line(tmp_path, spoil):
    (part,) = write_parts(tmp_path / "parts", (3,), cameras=CAMERAS)
    spoil(video_path(part, CAMERAS[1]))
    with pytest.raises(ValueError, match=re.escape(str(video_path(part, CAMERAS[1])))) as refused:
        merge([part], tmp_path)
    assert "\n" not in str(refused.value)


def test_a_reader_of_videos_that_gives_no_reason_is_named(tmp_path, monkeypatch):
    def fails(*_, **__):
        raise RuntimeError

    monkeypatch.setattr("controller.dataset.videos.imageio.imiter", fails)
    with pytest.raises(ValueError, match=r"\.mp4: RuntimeError$"):
        next(pictures(tmp_path / "part.mp4"))


def test_a_part_that_the_expert_never_led_makes_no_dataset(tmp_path):
    expert = np.zeros(50, bool)
    (part,) = write_parts(tmp_path / "parts", (3,), cameras=CAMERAS, expert=expert)
    with pytest.raises(ValueError, match="the expert led"):
        merge([part], tmp_path)


def test_without_cameras_whole_episodes_stay_with_the_tissue_that_was_sensed(tmp_path):
    merge(write_parts(tmp_path / "parts", (3,)), tmp_path)
    (episode,) = read_episodes(tmp_path)
    assert len(episode) == len(random_episode(3))
    assert TISSUE in episode.columns
