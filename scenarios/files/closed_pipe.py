"""Who reads our output may go away (`calot run | head -1`): work goes on, unread."""

import os
import sys
from collections.abc import Callable
from functools import wraps
from typing import IO, ParamSpec

from scenarios.files.exit_codes import ERROR

P = ParamSpec("P")


def outlives_its_readers(main: Callable[P, int]) -> Callable[P, int]:
    """Let a command end with its own exit code, and without a word, if nobody reads it."""

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
    """Print a line, to nobody if need be."""
    try:
        print(line, file=stream, flush=True)
    except BrokenPipeError:
        silence(stream)


def _flush(stream: IO[str] | None) -> None:
    """Write what is left now: at Python's own end it would become exit code 120."""
    try:
        if stream is not None:
            stream.flush()
    except BrokenPipeError:
        silence(stream)


def silence(stream: IO[str] | None) -> None:
    """Let what is written from now on go nowhere."""
    if stream is not None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
