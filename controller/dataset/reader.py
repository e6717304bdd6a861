"""Read and check the episodes of a dataset, one at a time, and sense them again.

Episodes that are sensed again have the same errors for every policy.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from controller.dataset import layout
from controller.dataset.choice import ALL, Choice
from controller.dataset.dataset_episode import DatasetEpisode, Header
from controller.dataset.part import one_line, require_versions
from controller.dataset.schema import NOT_FORKED, Feature, features
from controller.dataset.tables import columns_of, require_features
from planner.learning.files import from_json
from tissue_sim.sensing.tracker import Fork, sensed_again

_HEADER = ("seed", "kind", "scenario", "success", "world_version", "schema_version")
_JSON = ("anatomy", "failures", "versions", "cameras")
_LATER = ("sense", "checkpoints")  # an older dataset does not have them
_PLACE = ("data/chunk_index", "data/file_index")
_ROW = ("episode_index", "length", *_JSON, *_PLACE, *_HEADER)


def read_episodes(
    root: str | Path, columns: Sequence[str] | None = None, choice: Choice = ALL
) -> Iterator[DatasetEpisode]:
    """Yield the chosen episodes of a dataset in their order, with some columns, or with all.

    The dataset's description is checked at once, and each episode when it is read.

    Raises:
        ValueError: There is no dataset or no episode in it, or its schema or world differs.
            Columns are missing, unknown or of another shape, or numbers are not finite.
            A file is missing or damaged. The message is one line.
    """
    root = Path(root)
    there = features(require_dataset(root))
    asked = tuple(there) if columns is None else columns
    if unknown := [name for name in asked if name not in there]:
        raise ValueError(f"unknown columns {', '.join(unknown)}; there are {', '.join(there)}")
    return _episodes(root, asked, there, choice)


def require_dataset(root: Path) -> tuple[str, ...]:
    """Return the cameras of a dataset.

    Raises:
        ValueError: There is no dataset of the present schema and world, or no episode in it.
    """
    path = root / layout.INFO_PATH
    try:
        found = from_json(path.read_bytes())
    except (FileNotFoundError, NotADirectoryError):
        raise ValueError(f"{root}: there is no dataset, for want of {layout.INFO_PATH}") from None
    except (OSError, ValueError, RecursionError) as error:
        raise ValueError(f"{path}: it cannot be read: {one_line(error)}") from None
    own, described = _object_in(found, "calot"), _object_in(found, "features")
    try:
        require_versions(own.get("schema_version", 0), own.get("world_version", 0))
    except ValueError as error:
        raise ValueError(f"{root}: {error}") from None
    cameras = own.get("cameras", [])
    if not (isinstance(cameras, list) and all(isinstance(name, str) for name in cameras)):
        raise ValueError(f"{path}: cameras must be a list of names, got {cameras}")
    expected = layout.info(found.get("total_episodes", 0), found.get("total_frames", 0), cameras)
    for name, feature in expected["features"].items():
        if (have := described.get(name)) != feature:
            raise ValueError(f"{root}: column {name} is described as {have}, not {feature}")
    if not found.get("total_episodes"):
        raise ValueError(f"{root}: the dataset is empty")
    return tuple(cameras)


def _object_in(found: Any, name: str) -> Mapping[str, Any]:
    """Return the object of this name, or an empty one if there is none."""
    value = found.get(name) if isinstance(found, dict) else None
    return value if isinstance(value, dict) else {}


def read_rows(root: Path, more: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Return a row for each episode: its header, where its frames lie, and `more` columns.

    Raises:
        ValueError: The table is missing or damaged, or a column is missing. The message is one
            line.
    """
    path, columns = root / layout.EPISODES_PATH, [*_ROW, *more]
    try:
        table = pq.read_table(path, page_checksum_verification=True)
        if missing := [name for name in columns if name not in table.column_names]:
            raise ValueError(f"columns are missing: {', '.join(missing)}")
    except (OSError, ValueError, pa.ArrowException) as error:
        raise ValueError(f"{path}: {one_line(error)}") from error
    later = [name for name in _LATER if name in table.column_names]
    return table.select([*columns, *later]).to_pylist()


def _episodes(
    root: Path,
    columns: Sequence[str],
    there: Mapping[str, Feature],
    choice: Choice,
) -> Iterator[DatasetEpisode]:
    asked, path, group = {name: there[name] for name in columns}, None, 0
    rows = read_rows(root)
    for row, is_chosen in zip(rows, choice.of(rows), strict=True):
        place = dict(zip(("chunk_index", "file_index"), (row[key] for key in _PLACE), strict=True))
        before, path = path, root / layout.DATA_PATH.format(**place)
        try:
            if path != before:
                file, group = _opened(path, there), 0
            group += 1
            if not is_chosen:
                continue
            read = columns_of(file.read_row_group(group - 1, columns=[*columns]), asked)
            episode = DatasetEpisode(header=_header(row), columns=read)
            if len(episode) != row["length"]:
                raise ValueError(f"it has {len(episode)} frames, not {row['length']}")
        except (OSError, ValueError, IndexError, pa.ArrowException) as error:
            number = row["episode_index"]
            raise ValueError(f"{path}, episode {number}: {one_line(error)}") from error
        yield episode


def _opened(path: Path, there: Mapping[str, Feature]) -> pq.ParquetFile:
    file = pq.ParquetFile(path, page_checksum_verification=True)
    require_features(file.schema_arrow, there)
    return file


def _header(row: dict[str, Any]) -> Header:
    plain = {key: from_json(row[key]) for key in _JSON}
    if set(_LATER) <= row.keys():
        plain |= {"sense": row["sense"], "checkpoints": from_json(row["checkpoints"])}
    return msgspec.convert({key: row[key] for key in _HEADER} | plain, Header)


COPIES = 2  # of each episode, each sensed with other errors


def sensed_copy(
    exact: NDArray[np.float32], seed: int, copy: int, forks: Sequence[Fork] = ()
) -> NDArray[np.float32]:
    """Return the exact states (n, `VECTOR_SIZE`) of one episode with the errors of this copy."""
    return sensed_again(exact, np.random.default_rng([0xC0B1E5, seed, copy]), forks)


def forks_in(forked_from: NDArray[np.int64], segment: NDArray[np.int64]) -> list[Fork]:
    """Return the forks of an episode, from its columns of these names."""
    first = np.flatnonzero(np.diff(segment, prepend=-1))
    ends = np.append(first[1:], len(segment))
    return [
        Fork(int(forked_from[begin]), range(begin, end))
        for begin, end in zip(first.tolist(), ends.tolist(), strict=True)
        if forked_from[begin] != NOT_FORKED
    ]
