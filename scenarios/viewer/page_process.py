"""The page in a process of its own: in the loop's it would take turns with the loop."""

from __future__ import annotations

import signal
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from threading import Lock, Thread
from types import TracebackType
from typing import Concatenate, ParamSpec, Self, TypeVar

from scenarios.files.errors import BadInputError
from scenarios.viewer.session_state import SessionState

P = ParamSpec("P")
T = TypeVar("T")
GONE = EOFError, ConnectionError  # nobody is at the other end any more


class PageProcess:
    """Serves while its `with` block lasts; if the process dies, the episode goes on."""

    def __init__(self, desk: SessionState, *, host: str, port: int) -> None:
        spawn = get_context("spawn")
        self._life, life = spawn.Pipe()
        self._asked, line = spawn.Pipe()
        self._process = spawn.Process(target=_serve, args=(life, line, host, port), daemon=True)
        self._answering = Thread(
            target=answer, args=(self._asked, desk), name="calot-desk", daemon=True
        )
        self._ends = life, line

    def __enter__(self) -> Self:
        """Raises BadInputError where no page comes up."""
        on_ctrl_c = signal.signal(signal.SIGINT, signal.SIG_IGN)  # which the process takes over:
        self._process.start()  # Ctrl-C is for the loop, and that ends the page
        signal.signal(signal.SIGINT, on_ctrl_c)
        for end in self._ends:  # the process has its own
            end.close()
        self._answering.start()
        try:
            self.port: int = self._life.recv()
        except GONE:
            raise BadInputError("the page could not be served; see above") from None
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.kill()  # it holds nothing that could be lost
        self._process.join()
        self._life.close()
        self._asked.close()


class SessionLink:
    """Asks the desk at the other end, one deed at a time."""

    def __init__(self, connection: Connection) -> None:
        self._connection, self._lock = connection, Lock()

    def __call__(
        self, deed: Callable[Concatenate[SessionState, P], T], /, *args: P.args, **kwargs: P.kwargs
    ) -> T:
        with self._lock:
            try:
                self._connection.send((deed, args, kwargs))
                done, answer = self._connection.recv()
            except GONE:
                raise SystemExit from None  # ends this thread; the process ends as well
        if not done:
            raise answer
        return answer


def answer(connection: Connection, desk: SessionState) -> None:
    """Does at the desk what the page asks for, until it is gone."""
    with suppress(*GONE):
        while True:
            deed, args, kwargs = connection.recv()
            try:
                answer = True, deed(desk, *args, **kwargs)
            except Exception as error:
                answer = False, error
            connection.send(answer)


def _serve(life: Connection, line: Connection, host: str, port: int) -> None:
    """Of the page's process: tells its port, and serves until nobody is at the other end."""
    from scenarios.viewer.page import Page

    with Page(SessionLink(line), host=host, port=port) as page, suppress(*GONE):
        life.send(page.port)
        life.recv()
