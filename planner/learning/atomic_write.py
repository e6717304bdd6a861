"""Write a file completely or not at all."""

import os
from contextlib import suppress
from pathlib import Path

MOST_MOVES = 3


def write_atomic(path: Path, content: bytes) -> None:
    """Write `content` to `path` through a temporary file beside it; create its folder.

    The function begins again if the folder is moved away meanwhile.
    """
    for _ in range(MOST_MOVES):
        with suppress(FileNotFoundError):
            return _write(path, content)
    return _write(path, content)


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with partial.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
