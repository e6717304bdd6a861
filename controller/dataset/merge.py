"""Merge parts into a dataset: the new dataset is built beside the old one, then replaces it.

In parts with videos, each stretch that the expert led becomes an episode of its own. The reason is
that stock trainers cannot leave out frames. The videos stay whole. A part without such a stretch is
left out.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from controller.dataset import layout
from controller.dataset.card import CARD_PATH, card, is_foreign
from controller.dataset.dataset_episode import DatasetEpisode
from controller.dataset.part import read_part, video_path
from controller.dataset.schema import FPS, PICTURES, TEXTS, Feature, features
from controller.dataset.statistics import Statistics, pooled, statistics_of
from controller.dataset.tables import arrow_schema, table_of
from controller.dataset.videos import picture_statistics

BUILDING = ".merging"


def merge(parts: Sequence[Path], root: Path, file_most_mb: float = layout.DATA_FILE_MAX_MB) -> int:
    """Build the dataset `root` from these parts, in their order; return its number of frames.

    An older dataset at `root` stays intact until the new one replaces it. The parts are unchanged.

    Raises:
        ValueError: There is no part, or a part is damaged, or of another schema or world.
        OSError: The dataset cannot be written.
    """
    if not parts:
        raise ValueError(f"{root}: there is no episode to make a dataset of")
    building = root / BUILDING
    shutil.rmtree(building, ignore_errors=True)
    try:
        frames = _build(parts, building, file_most_mb)
        for name in ("meta", "data", "videos"):  # without meta there is no dataset
            shutil.rmtree(root / name, ignore_errors=True)
        for name in ("videos", "data", "meta"):
            if (building / name).exists():
                (building / name).rename(root / name)
        if not is_foreign(root / CARD_PATH):
            (building / CARD_PATH).rename(root / CARD_PATH)
    finally:
        shutil.rmtree(building, ignore_errors=True)
    return frames


def _build(parts: Sequence[Path], root: Path, file_most_mb: float) -> int:
    rows: list[dict[str, Any]] = []
    statistics: list[dict[str, Statistics]] = []
    cameras = read_part(parts[0]).header.cameras
    columns = features(cameras)
    with closing(_DataFiles(root, file_most_mb, columns)) as files:
        number = 0
        for part in parts:
            whole = _read(part, cameras)
            if not (episodes := list(_episodes_of(whole))):
                continue
            shown = _shown(part, whole, [stretch for stretch, _ in episodes])
            _copy_videos(part, cameras, root, number)
            for (stretch, one), pictures in zip(episodes, shown, strict=True):
                numbered = _numbered(one, len(rows), files.frames)
                statistics.append(statistics_of(numbered, columns) | pictures)
                rows.append(_row(one, len(rows), files.frames, statistics[-1]))
                rows[-1] |= files.add(table_of(numbered, columns))
                rows[-1] |= _filmed(cameras, number, stretch)
            number += 1
    if not rows:
        raise ValueError(f"{root.parent}: the expert led the arms in no part")
    _describe(root, rows, statistics, cameras)
    return files.frames


def _describe(
    root: Path,
    rows: list[dict[str, Any]],
    statistics: Sequence[Mapping[str, Statistics]],
    cameras: Sequence[str],
) -> None:
    _write_episodes(root / layout.EPISODES_PATH, rows)
    _write_tasks(root / layout.TASKS_PATH)
    whole = {name: pooled([s[name] for s in statistics]) for name in statistics[0]}
    _write_json(root / layout.STATS_PATH, {n: _plain(n, s) for n, s in whole.items()})
    frames = sum(row["length"] for row in rows)
    _write_json(root / layout.INFO_PATH, layout.info(len(rows), frames, cameras))
    (root / CARD_PATH).write_text(card(rows, cameras))


def _read(part: Path, cameras: Sequence[str]) -> DatasetEpisode:
    episode = read_part(part)
    if (there := tuple(episode.header.cameras)) != tuple(cameras):
        raise ValueError(
            f"{part}: its cameras are {', '.join(there) or 'none'}, those of other parts"
            f" {', '.join(cameras) or 'none'}: collect it into another folder"
        )
    return episode


def _episodes_of(part: DatasetEpisode) -> Iterator[tuple[slice, DatasetEpisode]]:
    """Yield the episodes of a part, each with the slice of its frames in the part."""
    if not part.header.cameras:
        yield slice(0, len(part)), part
        return
    for stretch in part.stretches():
        columns = {name: column[stretch] for name, column in part.columns.items()}
        numbers = np.arange(stretch.stop - stretch.start)
        columns |= {"frame_index": numbers, "timestamp": (numbers / FPS).astype(np.float32)}
        yield stretch, DatasetEpisode(header=part.header, columns=columns)


def _shown(
    part: Path, whole: DatasetEpisode, stretches: Sequence[slice]
) -> list[dict[str, Statistics]]:
    """Return the statistics of each stretch's pictures."""
    found = {
        PICTURES + camera: picture_statistics(video_path(part, camera), len(whole), stretches)
        for camera in whole.header.cameras
    }
    return [{name: each[k] for name, each in found.items()} for k in range(len(stretches))]


def _copy_videos(part: Path, cameras: Sequence[str], root: Path, number: int) -> None:
    for camera in cameras:
        path = root / layout.video_path(camera, number)
        path.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(video_path(part, camera), path)


def _filmed(cameras: Sequence[str], number: int, stretch: slice) -> dict[str, float]:
    """Return the positions at which the videos show an episode."""
    chunk, within = divmod(number, layout.FILES_A_CHUNK)
    return {
        f"videos/{PICTURES}{camera}/{name}": value
        for camera in cameras
        for name, value in {
            "chunk_index": chunk,
            "file_index": within,
            "from_timestamp": stretch.start / FPS,
            "to_timestamp": stretch.stop / FPS,
        }.items()
    }


def _plain(name: str, statistics: Statistics) -> dict[str, Any]:
    """Return statistics as lists; statistics of pictures have the shape (channels, 1, 1)."""
    pictures = {key for key in statistics if name.startswith(PICTURES) and key != "count"}
    return {
        key: (value[:, None, None] if key in pictures else value).tolist()
        for key, value in statistics.items()
    }


class _DataFiles:
    """Writes frames into one file after another, an episode a row group."""

    def __init__(self, root: Path, file_most_mb: float, columns: Mapping[str, Feature]) -> None:
        self._root, self._most_bytes = root, file_most_mb * 2**20
        self._schema = arrow_schema(columns)
        self._file, self._writer = -1, None
        self.frames = 0

    def add(self, table: pa.Table) -> dict[str, int]:
        """Write an episode; return its position in the files."""
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
            path, self._schema, compression="zstd", write_page_checksum=True
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
        "cameras": json.dumps(header["cameras"]),
        "checkpoints": json.dumps(header["checkpoints"]),
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
    """Write the tasks; the texts are the index for pandas, with which LeRobot reads."""
    words = "__index_level_0__"
    table = pa.table({"task_index": pa.array(range(len(TEXTS)), pa.int64()), words: TEXTS})
    column = {"name": None, "pandas_type": "unicode", "numpy_type": "object", "metadata": None}
    columns = [{**column, "field_name": words}]
    pandas = {"index_columns": [words], "column_indexes": [], "columns": columns}
    table = table.replace_schema_metadata({"pandas": json.dumps(pandas)})
    pq.write_table(table, path)


def _write_json(path: Path, content: Any) -> None:
    path.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n")
