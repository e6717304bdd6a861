"""Makes an expensive object once in a test run, for any number of workers."""

import fcntl
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Protocol, TypeVar

T = TypeVar("T")


class MadeOnce(Protocol):
    """Gives the result of `make`, which is called with a new folder, in one worker only."""

    def __call__(self, name: str, make: Callable[[Path], T]) -> T: ...


def made_once(root: Path, name: str, make: Callable[[Path], T]) -> T:
    """Return what `make` returned to the first worker that asked; the others wait for it.

    `make` gets a folder of its own below `root`, which all workers see; its result is pickled.
    """
    folder = root / name
    folder.mkdir(exist_ok=True)
    with (root / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        made = root / f"{name}.pickle"
        if not made.exists():
            made.write_bytes(pickle.dumps(make(folder)))
    return pickle.loads(made.read_bytes())
