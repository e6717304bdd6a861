"""Write and read one episode in its own file (a part); parts are merged into a dataset."""

from __future__ import annotations

import json
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path

import msgspec
import pyarrow as pa
import pyarrow.parquet as pq

from controller.dataset.dataset_episode import DatasetEpisode, Header
from controller.dataset.schema import SCHEMA_VERSION, demonstrated
from controller.dataset.tables import columns_of, table_of
from planner.learning.files import from_json
from tissue_sim.constants import WORLD_VERSION

_HEADER, _HASH = b"calot", b"sha256"  # of the header; pages have checksums of their own


def part_bytes(episode: DatasetEpisode) -> bytes:
    """Return the content of an episode's file.

    Raises:
        ValueError: A column is missing, of another shape or type, or not finite; or there is no
            frame.
    """
    if not len(episode):
        raise ValueError("an episode must have at least one frame")
    header = json.dumps(asdict(episode.header), allow_nan=False).encode()
    features = demonstrated(episode.header.cameras)
    said = {_HEADER: header, _HASH: sha256(header).hexdigest().encode()}
    table = table_of(episode.columns, features).replace_schema_metadata(said)
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, compression="zstd", write_page_checksum=True)
    return sink.getvalue().to_pybytes()


def video_path(part: Path, camera: str) -> Path:
    """Return the path of a camera's video of a part, with one picture per frame."""
    return part.with_suffix(f".{camera}.mp4")


def header_of(part: Path) -> Header:
    """Return the header of a part without reading its frames.

    Raises:
        ValueError: As in `read_part`.
    """
    try:
        return _header_of(pq.read_schema(part))
    except (OSError, ValueError, TypeError, pa.ArrowException) as error:
        raise ValueError(f"{part}: {one_line(error)}") from error


def read_part(path: Path) -> DatasetEpisode:
    """Read an episode from its file.

    Raises:
        ValueError: The file is damaged, or of another schema or world. The message is one line.
    """
    try:
        table = pq.read_table(path, page_checksum_verification=True)
        header = _header_of(table.schema)
        columns = columns_of(table, demonstrated(header.cameras))
        return DatasetEpisode(header=header, columns=columns)
    except (OSError, ValueError, TypeError, pa.ArrowException) as error:
        raise ValueError(f"{path}: {one_line(error)}") from error


def _header_of(schema: pa.Schema) -> Header:
    if _HEADER not in (metadata := schema.metadata or {}):
        raise ValueError("it is no demonstrated episode")
    digest = sha256(metadata[_HEADER]).hexdigest().encode()
    if metadata.get(_HASH, digest) != digest:
        raise ValueError("its header was changed after it was saved")
    header = msgspec.convert(from_json(metadata[_HEADER]), Header)
    require_versions(header.schema_version, header.world_version)
    return header


def require_versions(schema_version: int, world_version: int) -> None:
    """Raise ValueError unless both versions are the present ones."""
    if schema_version != SCHEMA_VERSION:
        raise ValueError(f"its schema is {schema_version}, not {SCHEMA_VERSION}: collect it again")
    if world_version != WORLD_VERSION:
        raise ValueError(
            f"its world is version {world_version}, not {WORLD_VERSION}: collect it again"
        )


def one_line(error: BaseException) -> str:
    """Return the first line of an error's message."""
    return next(iter(str(error).splitlines()), type(error).__name__)
