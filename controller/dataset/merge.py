"""Merge parts into a dataset: it is built beside the old one, then replaces it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from controller.dataset import layout
from controller.dataset.dataset_episode import DatasetEpisode
from controller.dataset.part import read_part
from controller.dataset.schema import FEATURES, TEXTS
from controller.dataset.statistics import Statistics, pooled, statistics_of
from controller.dataset.tables import arrow_schema, table_of

BUILDING = ".merging"


def merge(parts: Sequence[Path], root: Path, file_most_mb: float = layout.DATA_FILE_MAX_MB) -> int:
    """Make the dataset `root` of these parts, in their order; return its number of frames.

    An older dataset at `root` stays intact until it is replaced; the parts are not changed.

    Raises:
        ValueError: there is no part, or a part is damaged, or of another schema or world.
        OSError: the dataset cannot be written.
    """
    if not parts:
        raise ValueError(f"{root}: there is no episode to make a dataset of")
    building = root / BUILDING
    shutil.rmtree(building, ignore_errors=True)
    try:
        frames = _build(parts, building, file_most_mb)
        for folder in ("meta", "data"):  # without meta there is no dataset
            shutil.rmtree(root / folder, ignore_errors=True)
        for folder in ("data", "meta"):
            (building / folder).rename(root / folder)
    finally:
        shutil.rmtree(building, ignore_errors=True)
    return frames


def _build(parts: Sequence[Path], root: Path, file_most_mb: float) -> int:
    rows, statistics = [], []
    with closing(_DataFiles(root, file_most_mb)) as files:
        for episode in map(read_part, parts):
            columns = _numbered(episode, len(rows), files.frames)
            statistics.append(statistics_of(columns, FEATURES))
            rows.append(_row(episode, len(rows), files.frames, statistics[-1]))
            rows[-1] |= files.add(table_of(columns, FEATURES))
    _write_episodes(root / layout.EPISODES_PATH, rows)
    _write_tasks(root / layout.TASKS_PATH)
    whole = {name: pooled([s[name] for s in statistics]) for name in statistics[0]}
    lists = {n: {key: v.tolist() for key, v in s.items()} for n, s in whole.items()}
    _write_json(root / layout.STATS_PATH, lists)
    _write_json(root / layout.INFO_PATH, layout.info(len(rows), files.frames))
    return files.frames


class _DataFiles:
    """Writes frames into one file after another, an episode a row group."""

    def __init__(self, root: Path, file_most_mb: float) -> None:
        self._root, self._most_bytes = root, file_most_mb * 2**20
        self._file, self._writer = -1, None
        self.frames = 0

    def add(self, table: pa.Table) -> dict[str, int]:
        """Write an episode; return where it lies."""
        if self._writer is None or self._size_bytes() > self._most_bytes:
            self._next()
        assert self._writer is not None
        self._writer.write_table(table, row_group_size=len(table))
        self.frames += len(table)
        chunk, within = divmod(self._file, layout.FILES_A_CHUNK)
        return {"data/chunk_index": chunk, "data/file_index": within}

    def close(self) -> None:
        """Complete the last file."""
        if self._writer is not None:
            self._writer.close()

    def _size_bytes(self) -> int:
        return (self._root / layout.data_path(self._file)).stat().st_size

    def _next(self) -> None:
        self.close()
        self._file += 1
        path = self._root / layout.data_path(self._file)
        path.parent.mkdir(parents=True, exist_ok=True)
        self._writer = pq.ParquetWriter(
            path, arrow_schema(FEATURES), compression="zstd", write_page_checksum=True
        )


def _numbered(episode: DatasetEpisode, number: int, first_frame: int) -> dict[str, np.ndarray]:
    frames = len(episode)
    return {
        **episode.columns,
        "episode_index": np.full(frames, number),
        "index": np.arange(first_frame, first_frame + frames),
    }


def _row(
    episode: DatasetEpisode, number: int, first_frame: int, statistics: dict[str, Statistics]
) -> dict[str, Any]:
    header = asdict(episode.header)
    return {
        "episode_index": number,
        "tasks": list(dict.fromkeys(episode.columns["instruction"])),
        "length": len(episode),
        "dataset_from_index": first_frame,
        "dataset_to_index": first_frame + len(episode),
        "meta/episodes/chunk_index": 0,
        "meta/episodes/file_index": 0,
        **header,
        "anatomy": json.dumps(header["anatomy"]),
        "failures": json.dumps(header["failures"]),
        "versions": json.dumps(header["versions"]),
        **dict(_flat(statistics)),
    }


def _flat(statistics: dict[str, Statistics]) -> Iterator[tuple[str, list[float]]]:
    for name, of_column in statistics.items():
        for key, values in of_column.items():
            yield f"stats/{name}/{key}", values.tolist()


def _write_episodes(path: Path, rows: list[dict[str, Any]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.Table.from_pylist(rows), path, compression="zstd", write_page_checksum=True)


def _write_tasks(path: Path) -> None:
    """Write the tasks; the texts are the index for pandas, which LeRobot reads with."""
    words = "__index_level_0__"
    table = pa.table({"task_index": pa.array(range(len(TEXTS)), pa.int64()), words: TEXTS})
    column = {"name": None, "pandas_type": "unicode", "numpy_type": "object", "metadata": None}
    columns = [{**column, "field_name": words}]
    pandas = {"index_columns": [words], "column_indexes": [], "columns": columns}
    table = table.replace_schema_metadata({"pandas": json.dumps(pandas)})
    pq.write_table(table, path)


def _write_json(path: Path, content: Any) -> None:
    path.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n")
