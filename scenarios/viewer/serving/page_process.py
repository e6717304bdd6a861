"""Run the page in a separate process: in the loop's process it would slow the loop down."""

from __future__ import annotations

import signal
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from threading import Lock, Thread
from typing import Concatenate, ParamSpec, Self, TypeVar

from scenarios.files.errors import BadInputError
from scenarios.viewer.serving.gate import Gate, gate_for
from scenarios.viewer.session_state import SessionState
from tissue_sim.main_guard import require_main_guard

P = ParamSpec("P")
T = TypeVar("T")
GONE = EOFError, ConnectionError  # the other end of the connection is closed


class PageProcess:
    """Serves while its `with` block lasts. If the process dies, the episode continues."""

    def __init__(
        self, session: SessionState, *, host: str, port: int, say_port: int | None = None
    ) -> None:
        """Serve the session; `say_port` also takes `POST /say`.

        Raises:
            MainGuardError: The caller is a script that has no main guard.
        """
        require_main_guard()
        self.gate = gate_for(host)
        spawn = get_context("spawn")
        self._life, life = spawn.Pipe()
        pipes = [spawn.Pipe() for _ in range(2)]
        self._asked, lines = [here for here, _ in pipes], [there for _, there in pipes]
        self._process = spawn.Process(
            target=_serve, args=(life, lines, self.gate, host, port, say_port), daemon=True
        )
        self._answering = [
            Thread(target=answer, args=(asked, session), name="calot-session", daemon=True)
            for asked in self._asked
        ]
        self._ends = life, *lines

    def __enter__(self) -> Self:
        """Raise BadInputError if the page cannot be served."""
        on_ctrl_c = signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process inherits this:
        self._process.start()  # Ctrl-C is for the loop, which then ends the page
        signal.signal(signal.SIGINT, on_ctrl_c)
        for end in self._ends:  # the process holds its own copies
            end.close()
        for thread in self._answering:
            thread.start()
        try:
            self.port: int = self._life.recv()
        except GONE:
            raise BadInputError("cannot serve the page; see the error above") from None
        return self

    def __exit__(self, *exception: object) -> None:
        self._process.kill()  # it holds no data that could be lost
        self._process.join()
        self._life.close()
        for asked in self._asked:
            asked.close()


class SessionLink:
    """Calls methods of the session at the other end of a connection, one at a time."""

    def __init__(self, connection: Connection) -> None:
        self._connection, self._lock = connection, Lock()

    def __call__(
        self,
        method: Callable[Concatenate[SessionState, P], T],
        /,
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> T:
        with self._lock:
            try:
                self._connection.send((method, args, kwargs))
                done, reply = self._connection.recv()
            except GONE:
                raise SystemExit from None  # ends this thread; the process ends as well
        if not done:
            raise reply
        return reply


def answer(connection: Connection, session: SessionState) -> None:
    """Call the session's methods on the page's requests, until the connection closes."""
    with suppress(*GONE):
        while True:
            method, args, kwargs = connection.recv()
            try:
                reply = True, method(session, *args, **kwargs)
            except Exception as error:
                reply = False, error
            connection.send(reply)


def _serve(
    life: Connection,
    lines: Sequence[Connection],
    gate: Gate,
    host: str,
    port: int,
    say_port: int | None,
) -> None:
    """Run the page in its process: send its port, and serve until the connection closes.

    Slow calls go over the second line, so that no order waits for them.
    """
    from scenarios.loop.person.inbox import interpreter
    from scenarios.viewer.page import Page
    from scenarios.viewer.serving.say_server import say_server

    ask, ask_slowly = map(SessionLink, lines)
    with ExitStack() as served, suppress(*GONE):
        page = served.enter_context(Page(ask, ask_slowly, gate, host=host, port=port))
        Thread(target=interpreter().warm_up, name="calot-interpreter", daemon=True).start()
        if say_port is not None:
            served.enter_context(say_server(ask, gate, host=host, port=say_port))
        life.send(page.port)
        life.recv()
