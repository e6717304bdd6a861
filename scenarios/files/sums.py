"""Identify a folder by the names of its files, and its files by SHA-256.

The list of SHA-256 has the form that `sha256sum --check` reads.
"""

from __future__ import annotations

import re
from functools import cache
from hashlib import sha256
from pathlib import Path

RESULTS = "results.json"  # of `calot run` and of `calot evaluate`
MANIFEST = "evaluation.json"  # of `calot evaluate` only
SUMS = "SHA256SUMS"
LINE = re.compile(r"([0-9a-f]{64})  (\S.*)")
MOST_BYTES = 200_000_000


def digest_of(file: Path) -> str:
    """Return the SHA-256 of a file; it is computed again when the file is written again."""
    return _digest(file, file.stat().st_mtime_ns)


@cache
def _digest(file: Path, written_ns: int) -> str:
    del written_ns
    return sha256(file.read_bytes()).hexdigest()


def add_sum(folder: Path, name: str) -> None:
    """Append a file's line to the folder's list; the last line of a name counts.

    Raises:
        FileNotFoundError: The file is gone.
        OSError: The list cannot be written.
    """
    line = f"{digest_of(folder / name)}  {name}\n"
    with (folder / SUMS).open("a") as file:
        file.write(line)


def read_sums(folder: Path) -> dict[str, str]:
    """Return the digests by the names of files; an incomplete last line is left out.

    Raises:
        ValueError: The list is damaged.
        OSError: The list cannot be read.
    """
    path = folder / SUMS
    if not path.exists():
        return {}
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(f"{path} has more than {MOST_BYTES} bytes")
    *lines, _ = path.read_text().split("\n")
    found = [LINE.fullmatch(line) for line in lines]
    if None in found:
        raise ValueError(f"{path}, line {found.index(None) + 1}: it is no SHA-256 and a name")
    return {line[2]: line[1] for line in found if line is not None}
