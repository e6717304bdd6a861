"""Let a command continue when its reader closes the pipe (`calot run | head -1`)."""

import os
import sys
from collections.abc import Callable
from functools import wraps
from typing import IO, ParamSpec

from scenarios.files.exit_codes import ERROR

P = ParamSpec("P")


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
