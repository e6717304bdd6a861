"""A `calot` command in separate processes, for trials that interfere with it and check the rest."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self
from uuid import uuid4

PATIENCE_S = 120.0
ROOT = Path(__file__).parents[3]
_MARK = "CALOT_TRIAL"  # an environment variable, which children inherit


@dataclass(kw_only=True)
class CalotProcess:
    """A command that runs while a `with` block lasts, in a new session and folder.

    Attributes:
        words: Words of the command line, without `calot`.
        folder: Working folder; its temporary folder is made there.
        ignores: Signals that the command ignores from its start, as by `nohup`.
        mark: Identifies the command's processes.
    """

    words: Sequence[str]
    folder: Path
    ignores: Sequence[int] = ()
    mark: str = field(default_factory=lambda: uuid4().hex)

    @property
    def temporary(self) -> Path:
        """Return the folder that the command uses for temporary files."""
        return self.folder / "temporary"

    @property
    def pid(self) -> int:
        """Return the number of the command's first process."""
        return self._process.pid

    @property
    def is_running(self) -> bool:
        """Return whether the first process has not ended."""
        return self._process.poll() is None

    def __enter__(self) -> Self:
        self.temporary.mkdir(parents=True, exist_ok=True)
        own = {_MARK: self.mark, "TMPDIR": str(self.temporary), "PYTHONPATH": str(ROOT)}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "scenarios.cli", *self.words],
            cwd=self.folder,
            env=os.environ | {"OMP_NUM_THREADS": "1"} | own,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            preexec_fn=self._set_signals,
        )
        return self

    def __exit__(self, *exception: object) -> None:
        for pid in self.processes():
            _kill(pid)
        self._process.communicate()

    def _set_signals(self) -> None:
        for number in (signal.SIGINT, signal.SIGHUP):  # a shell's background job ignores them
            signal.signal(number, signal.SIG_IGN if number in self.ignores else signal.SIG_DFL)

    def wait_until_stoppable(self) -> None:
        """Wait until the command handles SIGTERM, or has ended."""
        wait_until(lambda: not self.is_running or _handles(self.pid, signal.SIGTERM))

    def end(self) -> tuple[int, str, str]:
        """Wait for the end; return the exit code, standard output and standard error.

        Raises:
            TimeoutExpired: The command does not end.
        """
        out, err = self._process.communicate(timeout=PATIENCE_S)
        return self._process.returncode, out, err

    def processes(self) -> list[int]:
        """Return the numbers of all processes of the command that are running."""
        return [pid for pid in _all_pids() if self.mark.encode() in _read(pid, "environ")]

    def workers(self) -> list[int]:
        """Return the numbers of the command's worker processes."""
        return [pid for pid in self.processes() if b"spawn_main" in _read(pid, "cmdline")]

    def left_running(self, grace_s: float) -> list[int]:
        """Return the processes that still run after `grace_s`."""
        end_s = time.monotonic() + grace_s
        while (left := self.processes()) and time.monotonic() < end_s:
            time.sleep(0.05)
        return left


def wait_until(condition: Callable[[], bool]) -> None:
    """Wait until the condition holds.

    Raises:
        TimeoutError: The condition does not hold for two minutes.
    """
    end_s = time.monotonic() + PATIENCE_S
    while not condition():
        if time.monotonic() > end_s:
            raise TimeoutError(f"nothing for {PATIENCE_S:.0f} s")
        time.sleep(0.02)


def _handles(pid: int, number: int) -> bool:
    lines = _read(pid, "status").decode().splitlines()
    caught = next((line.split()[1] for line in lines if line.startswith("SigCgt")), "0")
    return bool(int(caught, 16) >> (number - 1) & 1)


def _all_pids() -> list[int]:
    return [int(name) for name in os.listdir("/proc") if name.isdecimal()]


def _read(pid: int, name: str) -> bytes:
    try:
        return Path("/proc", str(pid), name).read_bytes()
    except OSError:  # the process has ended
        return b""


def _kill(pid: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)
