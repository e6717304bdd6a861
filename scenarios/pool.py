"""Attempts side by side, in processes that go from one to the next."""

import os
import signal
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, Generic, TypeVar

from scenarios.errors import WorkerDiedError

Config = TypeVar("Config")
Result = TypeVar("Result")

STOP_TIMEOUT_S = 10.0  # an interrupted worker saves its recording in far less


@dataclass(kw_only=True)
class _Worker(Generic[Config]):
    """A process at the other end of `connection`, and the attempt it is at."""

    process: BaseProcess
    connection: Connection
    config: Config

    def begin(self, config: Config) -> None:
        self.config = config
        with suppress(BrokenPipeError):  # it died since: `result` will say so
            self.connection.send(config)

    def result(self) -> Any:
        """Raises EOFError or ConnectionResetError if the process died."""
        return self.connection.recv()

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


def run_side_by_side(
    attempt: Callable[[Config], Result],
    configs: Sequence[Config],
    workers: int,
    after_death: Callable[[Config, WorkerDiedError], Result],
) -> Generator[Result, None, None]:
    """Yields each attempt's result as it ends; `after_death` gives that of a worker that died.

    The workers are fresh interpreters, to which `attempt` goes by pickle.
    Closing the iterator early interrupts the workers, which save what they have recorded.
    """
    waiting = list(configs)
    crew: list[_Worker[Config]] = []
    try:
        while waiting or crew:
            while waiting and len(crew) < workers:
                crew.append(_hire(attempt, waiting.pop(0)))
            for worker in _ready(crew):
                config = worker.config
                try:
                    result = worker.result()
                except (EOFError, ConnectionResetError):
                    crew.remove(worker)
                    worker.leave()
                    result = after_death(config, _death(worker))
                else:
                    if waiting:
                        worker.begin(waiting.pop(0))
                    else:
                        crew.remove(worker)
                        worker.leave()
                yield result
    finally:
        for worker in crew:
            worker.interrupt()
        for worker in crew:
            worker.leave()


def _hire(attempt: Callable[[Config], Any], config: Config) -> _Worker[Config]:
    context = get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(there, attempt), daemon=True)
    process.start()
    there.close()
    worker = _Worker(process=process, connection=here, config=config)
    worker.begin(config)
    return worker


def _ready(crew: list[_Worker[Config]]) -> list[_Worker[Config]]:
    ready = set(wait([worker.connection for worker in crew]))
    return [worker for worker in crew if worker.connection in ready]


def _death(worker: _Worker) -> WorkerDiedError:
    return WorkerDiedError(f"worker died with exit code {worker.process.exitcode}")


def _serve(connection: Connection, attempt: Callable[[Any], Any]) -> None:
    os.setpgid(0, 0)  # a terminal's Ctrl-C reaches the parent only, which passes it on once
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it
    with suppress(EOFError, OSError, KeyboardInterrupt):
        while True:
            connection.send(attempt(connection.recv()))
