"""What a file holds, kept for all episodes of a process."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")


def kept(load: Callable[[Path], T]) -> Callable[[Path], T]:
    """Return the loader that loads a file once, until it is written anew or another is asked for.

    All who ask share what was loaded, so it must have no state.
    """

    @lru_cache(maxsize=1)
    def loaded(path: Path, written_ns: int) -> T:
        del written_ns  # a file that is written anew is another one
        return load(path)

    return lambda path: loaded(path, path.stat().st_mtime_ns if path.exists() else 0)
