"""Keep the content of a file for all episodes of a process."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")


def kept(load: Callable[[Path], T]) -> Callable[[Path], T]:
    """Return a loader that loads a file once, until it changes or another file is requested.

    All callers share the loaded object, so the object must have no state.
    """

    @lru_cache(maxsize=1)
    def loaded(path: Path, written_ns: int) -> T:
        del written_ns  # a file that is written anew is another file
        return load(path)

    return lambda path: loaded(path, path.stat().st_mtime_ns if path.exists() else 0)
