"""Store files that a library can read only from disk, in one cache for all processes.

A temporary folder would remain after its process is killed.
"""

import os
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from tempfile import NamedTemporaryFile


def cache_root() -> Path:
    """Return the folder in which Calot and Warp keep files that can be made again."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def cached_folder(name: str, files: Mapping[str, bytes]) -> Path:
    """Return a folder that contains files, named by relative path; equal files share a folder.

    Raises:
        OSError: a file is missing and cannot be written.
    """
    content = b"\0".join(part for path in sorted(files) for part in (path.encode(), files[path]))
    folder = cache_root() / "calot" / f"{name}-{sha256(content).hexdigest()[:16]}"
    for path, wanted in files.items():
        _put(folder / path, wanted)
    return folder


def _put(path: Path, wanted: bytes) -> None:
    """Write a file unless it exists; write the whole file or nothing."""
    if path.exists() and path.read_bytes() == wanted:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with NamedTemporaryFile(dir=path.parent, delete=False) as partial:
        partial.write(wanted)
    os.replace(partial.name, path)
