"""A pool of worker processes on this machine."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from multiprocessing.resource_tracker import ensure_running
from threading import Thread
from typing import Any, TypeVar, cast

from scenarios.files.errors import WorkerDiedError
from scenarios.workers.job import Job, WorkerPool
from scenarios.workers.process import STOP_SIGNALS, counting, search_garbage_rarely, stoppable
from tissue_sim.main_guard import require_main_guard

Result = TypeVar("Result")

STOP_TIMEOUT_S = 10.0  # an interrupted worker saves its recording in far less


@dataclass(kw_only=True)
class _Worker:
    """A process at the other end of `connection`, and its current job."""

    process: BaseProcess
    connection: Connection
    job: Job | None = None

    def begin(self, job: Job) -> None:
        self.job = job
        with suppress(BrokenPipeError):  # the worker has died: `outcome` reports it
            self.connection.send(job.config)

    def outcome(self) -> Any:
        """Return the attempt's result, or the death of the worker."""
        try:
            return self.connection.recv()
        except (EOFError, ConnectionResetError):
            self.leave()
            return WorkerDiedError(f"worker died with exit code {self.process.exitcode}")

    def interrupt(self) -> None:
        """Send SIGINT once, as Ctrl-C does."""
        if self.process.pid is not None and self.process.is_alive():
            os.kill(self.process.pid, signal.SIGINT)

    def leave(self) -> None:
        """Close the connection, which ends the process; wait for its end; end its children."""
        self.connection.close()
        wait([self.process.sentinel], STOP_TIMEOUT_S)
        with suppress(ProcessLookupError):
            os.killpg(self.process.ident or 0, signal.SIGKILL)
        self.process.kill()  # in the parent's group still, if it has hardly begun
        self.process.join()


class LocalProcesses(WorkerPool[Result]):
    """A pool of spawned processes; idle ones are used again."""

    def __init__(self, attempt: Callable[[Any], Result]) -> None:
        """Make a pool, without processes yet.

        Raises:
            MainGuardError: The caller is a script that has no main guard.
        """
        require_main_guard()
        self._attempt = attempt
        self._busy: list[_Worker] = []
        self._idle: list[_Worker] = []

    @property
    def n_busy(self) -> int:
        return len(self._busy)

    def begin(self, job: Job) -> None:
        worker = self._idle.pop() if self._idle else _spawned(self._attempt)
        worker.begin(job)
        self._busy.append(worker)

    def wait(self) -> None:
        wait([worker.connection for worker in self._busy])

    def ended(self) -> list[tuple[Job, Result | WorkerDiedError]]:
        ready = set(wait([worker.connection for worker in self._busy], timeout=0.0))
        done = [worker for worker in self._busy if worker.connection in ready]
        self._busy = [worker for worker in self._busy if worker not in done]
        outcomes = [(cast(Job, worker.job), worker.outcome()) for worker in done]
        self._idle += [worker for worker in done if not worker.connection.closed]
        return outcomes

    def leave(self) -> list[Result]:
        stopping, idle, self._busy, self._idle = self._busy, self._idle, [], []
        for worker in stopping:
            worker.interrupt()
        last = [worker.outcome() for worker in stopping if worker.connection.poll(STOP_TIMEOUT_S)]
        for worker in (*stopping, *idle):
            worker.leave()
        return [outcome for outcome in last if not isinstance(outcome, WorkerDiedError)]


def _spawned(attempt: Callable[[Any], Any]) -> _Worker:
    context = get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(there, attempt), daemon=True)
    ensure_running()  # it would unblock them
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOP_SIGNALS)  # until it can handle them
    process.start()
    signal.pthread_sigmask(signal.SIG_SETMASK, before)
    there.close()
    return _Worker(process=process, connection=here)


def _serve(connection: Connection, attempt: Callable[[Any], Any]) -> None:
    os.setpgid(0, 0)  # a terminal's Ctrl-C reaches only the parent, which passes it on once
    for number in STOP_SIGNALS:  # a shell's background ignores Ctrl-C, `nohup` the end of a session
        signal.signal(number, signal.SIG_DFL)
    search_garbage_rarely()
    with suppress(KeyboardInterrupt), stoppable():
        signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)
        Thread(target=_stop_without_parent, name="calot-parent", daemon=True).start()
        for config in _received(connection):
            with counting():
                result = attempt(config)  # an exception ends the process, with its traceback
                with suppress(OSError):  # the parent is gone: no process can receive the result
                    connection.send(result)
    if _parent_is_gone(timeout_s=0.0):
        os.killpg(0, signal.SIGKILL)  # with its own children


def _stop_without_parent() -> None:
    """Stop this process once its parent has died, and then end it with its children."""
    _parent_is_gone(timeout_s=None)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(STOP_TIMEOUT_S)
    os.killpg(0, signal.SIGKILL)


def _parent_is_gone(timeout_s: float | None) -> bool:
    parent = parent_process()
    return parent is not None and bool(wait([parent.sentinel], timeout_s))


def _received(connection: Connection) -> Iterator[Any]:
    """Yield the parent's messages, until the parent closes the connection."""
    with suppress(EOFError, OSError):
        while True:
            yield connection.recv()
