"""Tests of the dataset: all that is written is read back bit for bit, from any file of it."""

import json
import re
from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest

from controller.dataset import layout
from controller.dataset.card import card
from controller.dataset.merge import merge
from controller.dataset.part import header_of, part_bytes, read_part
from controller.dataset.reader import read_episodes
from controller.dataset.schema import DEMONSTRATED, TEXTS, features
from tests.controller.dataset.episodes import random_episode, write_parts
from tissue_sim.sensing.observation import VECTOR_SIZE, encoded_and_tissue, fields

SEEDS = (3, 4, 5, 6)
ROW = {"kind": "nominal", "length": 5, "seed": 3, "success": True}


def assert_same_bits(a, b):
    assert a.keys() == b.keys()
    for name in a:
        assert a[name].dtype == b[name].dtype
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)


def contents(root):
    """Return the bytes of every file of the dataset, by its path in the dataset."""
    files = [path for part in ("data", "meta") for path in (root / part).rglob("*.*")]
    return {str(path.relative_to(root)): path.read_bytes() for path in files}


def test_a_part_is_read_back_bit_for_bit(tmp_path):
    episode = random_episode(0)
    path = tmp_path / "part.parquet"
    path.write_bytes(part_bytes(episode))
    read = read_part(path)
    assert_same_bits(dict(read.columns), dict(episode.columns))
    assert read.header.anatomy == episode.header.anatomy


def test_the_card_tells_what_each_number_of_the_state_is():
    vectors = np.arange(VECTOR_SIZE, dtype=np.float32)[None]
    state, _ = encoded_and_tissue(vectors)
    rows = re.findall(r"^\| (\d+)(?: to (\d+))? \| `(\w+)`", card([ROW], ()), re.M)
    for first, last, name in rows:
        there = state[0, int(first) : int(last or first) + 1]
        np.testing.assert_array_equal(there, fields(vectors)[name].ravel())
    first, last, _ = rows[-1]
    assert int(last or first) == state.shape[1] - 1


def told(episode, **changes):
    return replace(episode, header=replace(episode.header, **changes))


def test_how_an_episode_was_made_is_read_back_from_its_part_and_from_the_dataset(tmp_path):
    made = {"sense": "exact", "checkpoints": {"controller": "12ab", "planner": "34cd"}}
    path = tmp_path / "part.parquet"
    path.write_bytes(part_bytes(told(random_episode(0), **made)))
    merge([path], tmp_path)
    (read,) = read_episodes(tmp_path)
    for header in (header_of(path), read_part(path).header, read.header):
        assert {name: getattr(header, name) for name in made} == made


def test_what_an_older_version_wrote_is_read_though_it_does_not_tell_how_it_was_made(tmp_path):
    path = tmp_path / "part.parquet"
    path.write_bytes(part_bytes(random_episode(0)))
    table = pq.read_table(path)
    header = json.loads(table.schema.metadata[b"calot"])
    del header["sense"], header["checkpoints"]
    pq.write_table(table.replace_schema_metadata({b"calot": json.dumps(header).encode()}), path)
    merge([path], tmp_path)
    rows = pq.read_table(tmp_path / layout.EPISODES_PATH)
    pq.write_table(rows.drop_columns(["sense", "checkpoints"]), tmp_path / layout.EPISODES_PATH)
    (read,) = read_episodes(tmp_path)
    assert (read.header.sense, read.header.checkpoints) == ("", {})
    assert_same_bits(dict(read_part(path).columns), dict(random_episode(0).columns))


@pytest.mark.parametrize("file_most_mb", [1e-6, 0.05, 100.0])
def test_a_dataset_is_its_episodes_in_order_for_any_number_of_files(tmp_path, file_most_mb):
    frames = merge(write_parts(tmp_path / "parts", SEEDS), tmp_path, file_most_mb)
    read = list(read_episodes(tmp_path))
    assert [episode.header.seed for episode in read] == list(SEEDS)
    for number, (seed, episode) in enumerate(zip(SEEDS, read, strict=True)):
        own = {name: episode.columns[name] for name in DEMONSTRATED}
        assert_same_bits(own, dict(random_episode(seed).columns))
        assert (episode.columns["episode_index"] == number).all()
    index = np.concatenate([episode.columns["index"] for episode in read])
    np.testing.assert_array_equal(index, np.arange(frames))


@pytest.mark.parametrize("file_most_mb", [1e-6, 100.0])
def test_each_episodes_row_says_which_frames_are_its_own_and_in_which_file(tmp_path, file_most_mb):
    """Check the index of the first frame and the index after the last: LeRobot reads these."""
    merge(write_parts(tmp_path / "parts", SEEDS), tmp_path, file_most_mb)
    rows = pq.read_table(tmp_path / layout.EPISODES_PATH).to_pylist()
    for row, episode in zip(rows, read_episodes(tmp_path), strict=True):
        index = episode.columns["index"]
        assert row["episode_index"] == episode.columns["episode_index"][0]
        assert (row["dataset_from_index"], row["dataset_to_index"]) == (index[0], index[-1] + 1)
        assert row["length"] == len(index)
        file = layout.FILES_A_CHUNK * row["data/chunk_index"] + row["data/file_index"]
        inside = pq.read_table(tmp_path / layout.data_path(file)).to_pydict()["index"]
        assert set(index.tolist()) <= set(inside)


def test_parts_merged_later_give_the_same_dataset_as_all_at_once(tmp_path):
    parts = write_parts(tmp_path / "parts", SEEDS)
    merge(parts, tmp_path / "at once")
    merge(parts[:2], tmp_path / "by and by")
    merge(parts, tmp_path / "by and by")
    assert contents(tmp_path / "by and by") == contents(tmp_path / "at once")


def test_statistics_are_those_of_all_frames_together(tmp_path):
    merge(write_parts(tmp_path / "parts", SEEDS[:2]), tmp_path)
    merge(
        [
            *write_parts(tmp_path / "parts", SEEDS[:2]),
            *write_parts(tmp_path / "long", (9,), frames=500),
        ],
        tmp_path,
    )
    statistics = json.loads((tmp_path / layout.STATS_PATH).read_text())
    columns = [episode.columns for episode in read_episodes(tmp_path)]
    for name, feature in features(()).items():
        if not feature.is_number:
            assert name not in statistics
            continue
        values = np.concatenate([c[name] for c in columns]).astype(float).reshape(-1, feature.size)
        for key in ("min", "max", "mean", "std"):
            expected = getattr(np, key)(values, axis=0)
            np.testing.assert_allclose(statistics[name][key], expected, rtol=1e-9, atol=1e-12)
        assert statistics[name]["count"] == [len(values)]


def test_the_words_are_found_by_their_index(tmp_path):
    merge(write_parts(tmp_path / "parts", SEEDS[:1]), tmp_path)
    table = pq.read_table(tmp_path / layout.TASKS_PATH).to_pydict()
    assert table["__index_level_0__"] == list(TEXTS)
    assert table["task_index"] == list(range(len(TEXTS)))


def test_only_the_columns_asked_for_are_read(tmp_path):
    merge(write_parts(tmp_path / "parts", SEEDS[:1]), tmp_path)
    (episode,) = read_episodes(tmp_path, columns=("action", "expert"))
    assert set(episode.columns) == {"action", "expert"}


def test_stretches_are_unbroken_frames_of_the_expert():
    for seed in range(20):
        episode = random_episode(seed, frames=40)
        expert, segment = episode.columns["expert"], episode.columns["segment"]
        covered = np.zeros(40, int)
        for stretch in episode.stretches():
            covered[stretch] += 1
            assert len(set(segment[stretch].tolist())) == 1
            if stretch.stop < 40:
                assert not expert[stretch.stop] or segment[stretch.stop] != segment[stretch.start]
        np.testing.assert_array_equal(covered, expert.astype(int))
