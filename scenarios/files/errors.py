"""Errors around an episode, and their descriptions in one line."""

import traceback
from pathlib import Path


class BadInputError(ValueError):
    """A person's input is invalid; the message names the value and the allowed ones (exit 2)."""


class WorkerDiedError(RuntimeError):
    """The process that ran an episode ended without a result."""


def describe_error(error: BaseException) -> str:
    """Return the type and message of `error`."""
    return f"{type(error).__name__}: {error}".rstrip(": ")


def describe_with_place(error: BaseException) -> str:
    """Return the type and message of `error`, and the line that raised it if there is one."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    return describe_error(error) + place
