"""How a command ends: errors in one line, exit codes, and readers that close the pipe.

Most modules import this one, so it is light.
"""

import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import IO, ParamSpec

P = ParamSpec("P")

# exit codes; 0 is success
FAILED = 1  # an episode failed, a pass rate is too low, or a replay differs
BAD_INPUT = 2  # or a full disk
ERROR = 3  # an episode broke off, or the program did
INTERRUPTED = 130  # as after Ctrl-C in a shell


class BadInputError(ValueError):
    """A person's input is invalid; the message names the value and the allowed ones (exit 2)."""


@contextmanager
def refusing(*kinds: type[Exception], before: str = "", after: str = "") -> Iterator[None]:
    """Refuse the input of a block that raises one of these errors: in its words, and those around.

    Raises:
        BadInputError: The block did; of an error of the system it names only the reason.
    """
    try:
        yield
    except kinds as error:
        why = getattr(error, "strerror", None) or error
        raise BadInputError(f"{before}{why}{after}") from None


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


# A reader closes the pipe, as in `calot run | head -1`


def outlives_its_readers(main: Callable[P, int]) -> Callable[P, int]:
    """Let a command end with its own exit code, and without a message, if no reader is left."""

    @wraps(main)
    def to_its_end(*args: P.args, **kwargs: P.kwargs) -> int:
        try:
            return main(*args, **kwargs)
        except BrokenPipeError:
            return ERROR
        finally:
            for stream in (sys.stdout, sys.stderr):
                _flush(stream)

    return to_its_end


def say(line: str, stream: IO[str]) -> None:
    """Print a line; if no reader is left, drop it."""
    try:
        print(line, file=stream, flush=True)
    except BrokenPipeError:
        silence(stream)


def _flush(stream: IO[str] | None) -> None:
    """Flush the stream now: at Python's own end a failure would become exit code 120."""
    try:
        if stream is not None:
            stream.flush()
    except BrokenPipeError:
        silence(stream)


def silence(stream: IO[str] | None) -> None:
    """Discard all further output of a stream."""
    if stream is not None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
