"""Check before any work that a folder can be written to."""

import os
import tempfile
from contextlib import suppress
from pathlib import Path

from scenarios.files.errors import BadInputError


def require_writable_file(path: Path, option: str) -> None:
    """Check that a file can be written, as far as this can be known beforehand.

    Raises:
        BadInputError: a folder lies there, or its own folder cannot be written to.
    """
    if path.is_dir():
        raise BadInputError(f"{option}: {path} is a folder; name a file")
    require_writable_folder(path.parent, option)


def require_writable_folder(folder: Path, option: str) -> None:
    """Try to create `folder` and a file in it, then remove what was created.

    Raises:
        BadInputError: the folder cannot be written to; names the option and the reason.
    """
    real = Path(os.path.realpath(folder))  # "new/../x" is x
    missing = [path for path in (real, *real.parents) if not os.path.exists(path)]
    try:
        real.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=real):
            pass
    except OSError as error:
        raise BadInputError(
            f"{option}: cannot write to {folder} ({error.strerror});"
            " choose a folder that can be written to"
        ) from None
    finally:
        for path in filter(os.path.isdir, missing):
            with suppress(OSError):  # somebody else has begun to use it
                path.rmdir()
