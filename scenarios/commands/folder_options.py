"""Check before any work that folders can be written to, and keep other commands out of them.

The folders are those of results, and the caches with the world's compiled kernels.
"""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from scenarios.files.errors import BadInputError
from tissue_sim.cached_files import cache_root

LOCK = ".calot.lock"
LONGEST_PATH = 4096 - 256  # Linux's PATH_MAX, less what Calot writes below
ELSEWHERE = "choose a folder that can be written to"


def require_writable_file(path: Path, option: str) -> None:
    """Check that a file can be written, as far as this can be known beforehand.

    Raises:
        BadInputError: a folder lies there, its own folder cannot be written to, or its name is too
            long for the partial file beside it.
    """
    if os.path.isdir(path):
        raise BadInputError(f"{option}: {path} is a folder; name a file")
    require_writable_folder(path.parent, option)
    longest = os.pathconf(_existing(path.parent), "PC_NAME_MAX") - len(f"..{2**32}")
    if (length := len(os.fsencode(path.name))) > longest:
        raise BadInputError(f"{option}: a name of {length} bytes is too long; allowed: {longest}")


def require_writable_folder(folder: Path, option: str, room_bytes: int = 0) -> None:
    """Try to create `folder` and a file of that size in it, then remove what was created.

    Raises:
        BadInputError: the folder cannot be written to; names the option and the reason.
    """
    real = Path(os.path.realpath(folder))  # "new/../x" is x
    if len(os.fsencode(real)) > LONGEST_PATH:
        raise BadInputError(f"{option}: the path is longer than {LONGEST_PATH} bytes; {ELSEWHERE}")
    missing = _missing(real)
    try:
        real.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=real) as file:
            file.write(bytes(room_bytes))
    except OSError as error:
        raise BadInputError(
            f"{option}: cannot write to {folder} ({error.strerror}); {ELSEWHERE}"
        ) from None
    finally:
        _remove_empty(missing)


@contextmanager
def claimed(folder: Path, option: str) -> Iterator[None]:
    """Keep other commands from writing to `folder` while the block lasts.

    The operating system ends the lock with the process, however that ends.

    Raises:
        BadInputError: another command is writing there; names its process.
    """
    missing = _missing(Path(os.path.realpath(folder)))
    folder.mkdir(parents=True, exist_ok=True)
    lock = folder / LOCK
    with _locked(lock, option) as file:
        file.write(str(os.getpid()))
        file.flush()
        try:
            yield
        finally:
            with suppress(OSError):  # the folder has vanished
                lock.unlink()
            _remove_empty(missing)


def _locked(lock: Path, option: str) -> IO[str]:
    """Open the file and lock it; not one that its holder removes meanwhile."""
    while True:
        file = lock.open("a+")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            raise BadInputError(
                f"{option}: process {file.read() or 'unknown'} is writing to {lock.parent}; wait"
                " until it has ended, or name another folder"
            ) from None
        except OSError:  # this file system has no locks
            return file
        with suppress(OSError):
            if os.path.samestat(os.fstat(file.fileno()), lock.stat()):
                file.truncate(0)
                return file
        file.close()


def _missing(real: Path) -> list[Path]:
    return [path for path in (real, *real.parents) if not os.path.exists(path)]


def _existing(folder: Path) -> Path:
    real = Path(os.path.realpath(folder))
    return next(path for path in (real, *real.parents) if os.path.isdir(path))


def _remove_empty(folders: list[Path]) -> None:
    for path in filter(os.path.isdir, folders):
        with suppress(OSError):  # somebody has begun to use it
            path.rmdir()


ROOM_BYTES = 4_000_000  # the kernels and what the renderer reads take half of it


def require_kernel_cache() -> None:
    """Check that the caches can be written to, or hold all that a world needs.

    Raises:
        BadInputError: neither; names the folder, and the variable that names another one.
    """
    folders = [("XDG_CACHE_HOME", cache_root() / "calot")]
    if kernels := os.environ.get("WARP_CACHE_PATH"):
        folders.append(("WARP_CACHE_PATH", Path(kernels)))
    try:
        for variable, folder in folders:
            require_writable_folder(folder, variable, ROOM_BYTES)
    except BadInputError:
        if not _a_world_begins():
            raise


def _a_world_begins() -> bool:
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # as for every episode
    from scenarios.loop.episode_config import EpisodeConfig
    from scenarios.run_episode import begin

    try:
        episode = begin(EpisodeConfig(planner="rule", controller="idle"))
        next(iter(episode.steps()))
    except Exception:  # Warp raises it where it cannot compile
        return False
    return True
