"""Whether a place can be written to, found out before any work is done."""

import os
import tempfile
from pathlib import Path

from scenarios.files.errors import BadInputError


def require_writable_folder(folder: Path, option: str) -> None:
    """Tries to make `folder`, if need be, and a file in it; leaves things as they were.

    Raises:
        BadInputError: If it cannot be written to; names the option and the reason.
    """
    missing = [path for path in (folder, *folder.parents) if not os.path.exists(path)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BadInputError(
            f"{option}: cannot write to {folder} ({error.strerror});"
            " name a folder that can be written to"
        ) from None
    finally:
        for path in filter(os.path.isdir, missing):
            path.rmdir()
