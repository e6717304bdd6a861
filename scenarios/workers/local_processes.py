"""Workers that are processes of this machine, each going from one attempt to the next."""

import os
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, Generic, TypeVar

from scenarios.files.errors import WorkerDiedError

Config = TypeVar("Config")
Result = TypeVar("Result")

STOP_TIMEOUT_S = 10.0  # an interrupted worker saves its recording in far less


@dataclass(kw_only=True)
class _Worker:
    """A process at the other end of `connection`, and the number of the attempt it is at."""

    process: BaseProcess
    connection: Connection
    number: int = -1

    def begin(self, number: int, config: Any) -> None:
        self.number = number
        with suppress(BrokenPipeError):  # it died since: `outcome` will say so
            self.connection.send(config)

    def outcome(self) -> Any:
        """What its attempt came to, or its own death."""
        try:
            return self.connection.recv()
        except (EOFError, ConnectionResetError):
            self.leave()
            return WorkerDiedError(f"worker died with exit code {self.process.exitcode}")

    def interrupt(self) -> None:
        """Does once what Ctrl-C does to a command."""
        if self.process.pid is not None and self.process.is_alive():
            os.kill(self.process.pid, signal.SIGINT)

    def leave(self) -> None:
        """Lets the process end, as it does when nobody is at this end, and waits for that."""
        self.connection.close()
        self.process.join(STOP_TIMEOUT_S)
        self.process.kill()
        self.process.join()


class CrewProcesses(Generic[Config, Result]):
    """Fresh interpreters; those that have ended their attempt wait for the next."""

    def __init__(self, attempt: Callable[[Config], Result]) -> None:
        self._attempt = attempt
        self._busy: list[_Worker] = []
        self._idle: list[_Worker] = []

    @property
    def n_busy(self) -> int:
        """How many attempts are under way."""
        return len(self._busy)

    def begin(self, number: int, config: Config) -> None:
        """Has an idle worker at it, or a new one."""
        worker = self._idle.pop() if self._idle else _hired(self._attempt)
        worker.begin(number, config)
        self._busy.append(worker)

    def ended(self) -> list[tuple[int, Result | WorkerDiedError]]:
        """Waits until some attempts have ended; returns what came of them."""
        ready = set(wait([worker.connection for worker in self._busy]))
        done = [worker for worker in self._busy if worker.connection in ready]
        self._busy = [worker for worker in self._busy if worker not in done]
        outcomes = [(worker.number, worker.outcome()) for worker in done]
        self._idle += [worker for worker in done if not worker.connection.closed]
        return outcomes

    def leave(self) -> None:
        """Interrupts what is under way, lets it be saved, and dismisses all."""
        for worker in self._busy:
            worker.interrupt()
        for worker in (*self._busy, *self._idle):
            worker.leave()


def _hired(attempt: Callable[[Any], Any]) -> _Worker:
    context = get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(there, attempt), daemon=True)
    process.start()
    there.close()
    return _Worker(process=process, connection=here)


def _serve(connection: Connection, attempt: Callable[[Any], Any]) -> None:
    os.setpgid(0, 0)  # a terminal's Ctrl-C reaches the parent only, which passes it on once
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it
    with suppress(EOFError, OSError, KeyboardInterrupt):
        while True:
            connection.send(attempt(connection.recv()))
