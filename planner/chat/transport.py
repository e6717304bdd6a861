"""Send one HTTP request and get its whole reply within a time limit, however slow the reply."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from http.client import HTTPConnection, HTTPException
from socket import SHUT_RDWR
from threading import Thread
from typing import Any, TypeVar
from urllib.error import HTTPError
from urllib.request import (
    HTTPHandler,
    HTTPRedirectHandler,
    HTTPSHandler,
    Request,
    build_opener,
)

from planner.chat.endpoint import EndpointError

MAX_BYTES = 1_000_000
MAX_WORDS = 200  # characters of a server's words that are reported
THREAD = "request to a language model"
T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Reply:
    """A server's reply, with any status."""

    status: int
    reason: str
    headers: Mapping[str, str]
    content: bytes

    @property
    def kind(self) -> str:
        """Return the content's type, without its parameters."""
        return self.headers.get("Content-Type", "").partition(";")[0].strip().lower()

    @property
    def words(self) -> str:
        """Return the server's description of an error, in a line; "" where there is none."""
        text = self.content.decode(errors="replace")
        try:
            said = json.loads(text)
        except (ValueError, RecursionError):
            said = "" if self.kind == "text/html" else text
        while isinstance(said, dict):  # {"error": {"message": ...}}, {"detail": ...} and the like
            said = next((said[key] for key in ("error", "message", "detail") if key in said), "")
        printable = "".join(c if c.isprintable() else " " for c in str(said or ""))
        return " ".join(printable.split())[:MAX_WORDS]


def post(address: str, body: bytes, headers: Mapping[str, str], limit_s: float) -> Reply:
    """Send a request and return the whole reply.

    Raises:
        TimeoutError: The whole reply did not come within the limit.
        EndpointError: The server cannot be reached, or sends too much.
    """
    request = Request(address, data=body, headers=dict(headers), method="POST")
    line = _Line()
    try:
        return _within(limit_s, partial(_exchange, line, request, limit_s))
    except TimeoutError:
        line.hang_up()
        raise
    except (OSError, HTTPException) as error:
        reason = getattr(error, "reason", None) or error
        if isinstance(reason, TimeoutError):
            raise TimeoutError from None
        raise EndpointError(f"it cannot be reached: {reason}") from None


def _within(limit_s: float, call: Callable[[], T]) -> T:
    """Return the result of a call, or raise TimeoutError and leave the call running.

    The timeout of a socket limits each read, and the look-up of a name has no timeout.
    """
    future: Future[T] = Future()

    def run() -> None:
        try:
            future.set_result(call())
        except Exception as error:
            future.set_exception(error)

    Thread(target=run, name=THREAD, daemon=True).start()
    return future.result(timeout=max(limit_s, 0.0))


class _Line(HTTPSHandler, HTTPHandler):
    """Opens one connection, which another thread can cut."""

    _connection: HTTPConnection | None = None

    def do_open(self, http_class: Any, req: Request, **options: Any) -> Any:
        """Connect as usual, and keep the connection."""

        def connection(host: str, **more: Any) -> HTTPConnection:
            self._connection = made = http_class(host, **more)
            return made

        return super().do_open(connection, req, **options)  # pyright: ignore[reportArgumentType]

    def hang_up(self) -> None:
        """Cut the connection if it is open, so that the thread that reads from it ends."""
        if self._connection is not None and self._connection.sock is not None:
            with suppress(OSError):
                self._connection.sock.shutdown(SHUT_RDWR)


class _NoRedirect(HTTPRedirectHandler):
    """Refuses redirects, so that the key is sent to the named address only."""

    def redirect_request(self, req: Any, fp: Any, code: int, *_: Any) -> None:
        raise HTTPError(req.full_url, code, "and sends elsewhere", req.headers, fp)


def _exchange(line: _Line, request: Request, limit_s: float) -> Reply:
    until_s = time.monotonic() + limit_s
    answer: Any
    try:
        answer = build_opener(line, _NoRedirect).open(request, timeout=limit_s)
    except HTTPError as error:
        answer = error
    with answer:
        return Reply(
            status=answer.status,
            reason=answer.reason,
            headers=answer.headers,
            content=_read(answer, until_s),
        )


def _read(answer: Any, until_s: float) -> bytes:
    content = b""
    while part := answer.read1(65_536):
        content += part
        if len(content) > MAX_BYTES:
            raise EndpointError(f"its answer is longer than {MAX_BYTES} bytes")
        if time.monotonic() > until_s:
            raise TimeoutError
    return content
