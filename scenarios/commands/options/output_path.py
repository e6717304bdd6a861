"""Check before any work that a folder can be written to."""

import os
import tempfile
from pathlib import Path

from scenarios.files.errors import BadInputError


def require_writable_folder(folder: Path, option: str) -> None:
    """Try to create `folder` and a file in it, then remove what was created.

    Raises:
        BadInputError: the folder cannot be written to; names the option and the reason.
    """
    missing = [path for path in (folder, *folder.parents) if not os.path.exists(path)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BadInputError(
            f"{option}: cannot write to {folder} ({error.strerror});"
            " choose a folder that can be written to"
        ) from None
    finally:
        for path in filter(os.path.isdir, missing):
            path.rmdir()
