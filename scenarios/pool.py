"""Episodes side by side, in processes that go from one episode to the next."""

import os
import signal
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess

from scenarios.attempt import broken_off
from scenarios.episode_config import EpisodeConfig
from scenarios.errors import WorkerDiedError
from scenarios.results import EpisodeResult

Attempt = Callable[[EpisodeConfig], EpisodeResult]

STOP_TIMEOUT_S = 10.0  # an interrupted worker saves its recording in far less


@dataclass(kw_only=True)
class _Worker:
    """A process at the other end of `connection`, and the episode it is at."""

    process: BaseProcess
    connection: Connection
    config: EpisodeConfig

    def begin(self, config: EpisodeConfig) -> None:
        self.config = config
        with suppress(BrokenPipeError):  # it died since: `result` will say so
            self.connection.send(config)

    def result(self) -> EpisodeResult:
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
    attempt: Attempt, configs: Sequence[EpisodeConfig], workers: int
) -> Generator[EpisodeResult, None, None]:
    """Yields the result of each episode as it ends; a worker that dies costs its episode only.

    The workers are fresh interpreters, to which `attempt` goes by pickle.
    Closing the iterator early interrupts the workers, which save what they have recorded.
    """
    waiting = list(configs)
    crew: list[_Worker] = []
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
                    result = broken_off(config, _death(worker))
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


def _hire(attempt: Attempt, config: EpisodeConfig) -> _Worker:
    context = get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(there, attempt), daemon=True)
    process.start()
    there.close()
    worker = _Worker(process=process, connection=here, config=config)
    worker.begin(config)
    return worker


def _ready(crew: list[_Worker]) -> list[_Worker]:
    ready = set(wait([worker.connection for worker in crew]))
    return [worker for worker in crew if worker.connection in ready]


def _death(worker: _Worker) -> WorkerDiedError:
    return WorkerDiedError(f"worker died with exit code {worker.process.exitcode}")


def _serve(connection: Connection, attempt: Attempt) -> None:
    os.setpgid(0, 0)  # a terminal's Ctrl-C reaches the parent only, which passes it on once
    with suppress(EOFError, OSError, KeyboardInterrupt):
        while True:
            connection.send(attempt(connection.recv()))
