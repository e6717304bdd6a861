"""Set up a process that runs episodes: signals stop it, and it rarely searches for garbage.

Ctrl-C, SIGTERM and SIGHUP stop a command, each as Ctrl-C does. A signal raises KeyboardInterrupt at
the program's current place. It waits while something is saved, and between the end of an episode
and the note of its result. Saving after a signal is not cut short by the next signal: only SIGKILL
ends a program at once.
"""

import gc
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import current_thread, main_thread
from types import FrameType

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
SHELL_BASE = 128  # a shell reports the end by a signal as this plus its number


@dataclass(kw_only=True)
class _Stop:
    """The signals so far, and whether further ones wait.

    Attributes:
        number: The first signal that came; 0 for none.
        raised: Whether it has been raised.
        saving: Whether signals wait now.
        counting: Whether signals wait from the first save to the end of the block.
    """

    number: int = 0
    raised: bool = False
    saving: bool = False
    counting: bool = False

    def receive(self, number: int, frame: FrameType | None) -> None:
        del frame
        self.number = self.number or number
        if number == signal.SIGHUP:
            _leave_terminal()
        if not self.saving:
            self.raised = True
            raise KeyboardInterrupt

    def release(self) -> None:
        """Raise a signal that waited; later signals wait for good."""
        if self.number and not self.raised:
            self.raised = self.saving = True
            raise KeyboardInterrupt


_stop = _Stop()


@contextmanager
def stoppable(*, ends_program: bool = False) -> Iterator[None]:
    """Let each signal raise KeyboardInterrupt in this process while the block lasts.

    A signal that the process was started to ignore, as by `nohup`, is ignored still.

    Args:
        ends_program: Whether signals are ignored after the block. The work is done then, and its
            exit code must not be lost while Python takes its time to end.
    """
    if current_thread() is not main_thread():  # Python handles signals in the main thread only
        yield
        return
    _stop.__init__()
    handlers = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    for number, before in handlers.items():
        if before is not signal.SIG_IGN:
            signal.signal(number, _stop.receive)
    try:
        yield
    finally:
        _stop.saving = True
        ends = ends_program or _stop.number  # a program that ends is not stopped again
        for number, before in handlers.items():
            signal.signal(number, signal.SIG_IGN if ends else before)


@contextmanager
def saving() -> Iterator[None]:
    """Let signals wait while the block saves something; after a signal, for good."""
    if current_thread() is not main_thread():
        yield
        return
    _stop.saving = True
    try:
        yield
    finally:
        _stop.saving = _stop.counting or _stop.raised
    if not _stop.counting:
        _stop.release()


@contextmanager
def counting() -> Iterator[None]:
    """Let a signal after the first save in the block wait until the block's end."""
    _stop.counting = True
    try:
        yield
    finally:
        _stop.counting, _stop.saving = False, _stop.raised and _stop.saving
    _stop.release()


@contextmanager
def importing() -> Iterator[None]:
    """Let signals wait while the block imports: trimesh takes one for a missing package."""
    before, _stop.saving = _stop.saving, True
    try:
        yield
    finally:
        _stop.saving = before
    if not before:
        _stop.release()


def stop_code() -> int:
    """Return the exit code of a program that a signal stopped."""
    return SHELL_BASE + (_stop.number or signal.SIGINT)


def _leave_terminal() -> None:
    """Discard output from now on: the terminal has hung up, and writing to it fails."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (1, 2):
        if os.isatty(stream):
            os.dup2(nowhere, stream)
    os.close(nowhere)


OBJECTS = 100_000  # Python's own 700 costs half a second while libraries are imported


def search_garbage_rarely() -> None:
    """Let Python search for garbage only after `OBJECTS` new objects, in this whole process.

    A program that calls `run_episode` itself decides this for itself.
    """
    gc.set_threshold(OBJECTS)
