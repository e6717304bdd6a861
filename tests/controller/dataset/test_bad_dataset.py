"""Tests of bad datasets: an error names the fault in one line, before any data is used."""

import json
import re

import numpy as np
import pyarrow.parquet as pq
import pytest

from controller.dataset import layout
from controller.dataset.merge import merge
from controller.dataset.part import part_bytes, read_part
from controller.dataset.reader import read_episodes
from tests.controller.dataset.episodes import random_episode, write_parts


@pytest.fixture
def root(tmp_path):
    merge(write_parts(tmp_path / "parts", (0, 1)), tmp_path)
    return tmp_path


def refusal(root):
    with pytest.raises(ValueError, match=re.escape(str(root))) as refused:
        list(read_episodes(root))
    assert "\n" not in str(refused.value)
    return str(refused.value)


def rewrite_info(root, **changes):
    path = root / layout.INFO_PATH
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def rewrite_data(root, change):
    path = root / layout.data_path(0)
    table = change(pq.read_table(path))
    pq.write_table(table, path, row_group_size=50)


def replaced(name, array):
    def change(table):
        return table.set_column(table.schema.get_field_index(name), name, array(table))

    return change


def test_a_missing_dataset_is_refused(tmp_path):
    assert "there is no dataset" in refusal(tmp_path)


def test_a_file_is_no_dataset(tmp_path):
    path = tmp_path / "README.md"
    path.write_text("a file")
    assert "there is no dataset" in refusal(path)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"\xff", "cannot be read"),
        (b"[" * 100_000, "cannot be read"),
        (b"[]", "its schema is 0"),
        (b'{"calot": []}', "its schema is 0"),
    ],
)
def test_a_description_of_another_form_is_refused(root, content, said):
    (root / layout.INFO_PATH).write_bytes(content)
    assert said in refusal(root)


@pytest.mark.parametrize("cameras", [5, [1], "endoscope_left"])
def test_cameras_that_are_no_list_of_names_are_refused(root, cameras):
    known = json.loads((root / layout.INFO_PATH).read_text())["calot"]
    rewrite_info(root, calot=known | {"cameras": cameras})
    assert "cameras must be a list of names" in refusal(root)


def test_columns_that_are_not_described_are_refused(root):
    rewrite_info(root, features=[])
    assert "is described as None" in refusal(root)


def test_a_folder_in_place_of_the_description_is_refused(root):
    (root / layout.INFO_PATH).unlink()
    (root / layout.INFO_PATH).mkdir()
    assert "cannot be read" in refusal(root)


def test_an_empty_dataset_is_refused(root):
    rewrite_info(root, total_episodes=0)
    assert "empty" in refusal(root)


@pytest.mark.parametrize("version", ["schema_version", "world_version"])
def test_another_version_is_refused(root, version):
    known = json.loads((root / layout.INFO_PATH).read_text())["calot"]
    rewrite_info(root, calot=known | {version: 0})
    assert "collect it again" in refusal(root)


def test_another_shape_is_described(root):
    features = json.loads((root / layout.INFO_PATH).read_text())["features"]
    features["action"]["shape"] = [14]
    rewrite_info(root, features=features)
    assert "column action" in refusal(root)


def test_a_column_is_missing(root):
    rewrite_data(root, lambda table: table.drop_columns(["flag"]))
    assert "missing: flag" in refusal(root)


def test_a_column_of_the_episodes_is_missing(root):
    path = root / layout.EPISODES_PATH
    pq.write_table(pq.read_table(path).drop_columns(["anatomy"]), path)
    assert "missing: anatomy" in refusal(root)


def test_a_column_has_another_type(root):
    rewrite_data(root, replaced("task", lambda t: t["task"].cast("int32")))
    assert "column task is int32" in refusal(root)


def test_a_number_is_not_finite(root):
    def spoiled(table):
        values = table["timestamp"].to_numpy().copy()
        values[7] = np.nan
        return [values]

    rewrite_data(root, replaced("timestamp", spoiled))
    assert "timestamp has a number that is not finite, in frame 7" in refusal(root)


def test_frames_are_missing(root):
    rewrite_data(root, lambda table: table.slice(0, 90))
    assert "episode 1" in refusal(root)


@pytest.mark.parametrize("path", [layout.data_path(0), layout.EPISODES_PATH])
def test_a_file_is_missing(root, path):
    (root / path).unlink()
    assert path in refusal(root)


@pytest.mark.parametrize("where", [0.1, 0.3, 0.5, 0.7, 0.999])
def test_a_damaged_part_is_refused_and_the_old_dataset_stays(root, where):
    parts = write_parts(root / "parts", (0, 1))
    content = bytearray(parts[1].read_bytes())
    content[int(where * len(content))] ^= 0xFF
    parts[1].write_bytes(content)
    with pytest.raises(ValueError, match=re.escape(str(parts[1]))) as refused:
        merge(parts, root)
    assert "\n" not in str(refused.value)
    assert len(list(read_episodes(root))) == 2


def test_a_part_cut_short_is_refused(tmp_path):
    (path,) = write_parts(tmp_path, (0,))
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(ValueError, match=re.escape(str(path))):
        read_part(path)


def test_invalid_columns_are_not_written():
    action = random_episode(0).columns["action"]
    with pytest.raises(ValueError, match="not finite, in frame 0"):
        part_bytes(random_episode(0, action=action * np.inf))
    with pytest.raises(ValueError, match=r"column action is float32 \(50, 19\)"):
        part_bytes(random_episode(0, action=action[:, :19]))
    with pytest.raises(ValueError, match="at least one frame"):
        part_bytes(random_episode(0, frames=0))


def test_a_dataset_of_no_parts_is_refused(tmp_path):
    with pytest.raises(ValueError, match="no episode"):
        merge([], tmp_path)
