"""`POST /say`: a person at the microphone page, or any program, speaks to the episode.

A client may send anything, or nothing. Its whole request must arrive within `LIMIT_S`. A body is
read up to `MOST_BYTES`. A longer body holds the arms, because it may contain a stop.
"""

from __future__ import annotations

import json
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from threading import Thread, Timer
from typing import Any

from planner.language.reading import Reading
from scenarios.loop.person.inbox import LONGEST, read, too_long
from scenarios.viewer.serving.gate import Gate, Headers
from scenarios.viewer.serving.port import family_of
from scenarios.viewer.session_state import Asks, SessionState

PAGE = files("scenarios.viewer").joinpath("microphone.html")
MOST_BYTES = 12 * LONGEST + 100  # of a body: JSON may write a letter as two \\uXXXX
LIMIT_S = 10.0  # from connecting to the end of the body; assumed: a slow network's


@contextmanager
def say_server(ask: Asks, gate: Gate, *, host: str, port: int) -> Iterator[None]:
    """Serve `POST /say`, and the page with the microphone, while the block lasts."""
    kind = type("Server", (_Server,), {"address_family": family_of(host)})
    server = kind((host, port), _handler(ask, gate))
    Thread(target=server.serve_forever, name="calot-say", daemon=True).start()
    try:
        yield
    finally:
        server.shutdown()
        server.server_close()


def spoken_in(body: bytes, kind: str) -> tuple[str, bool]:
    """Return the text of a body, plain or JSON {"text": TEXT}, and whether its speaker goes on.

    A recogniser that expects more speech reports it: {"text": TEXT, "unfinished": true}.

    Raises:
        ValueError: The body is neither.
    """
    if "json" not in kind:
        return body.decode("utf-8"), False
    try:
        content = json.loads(body)
    except RecursionError:
        raise ValueError("the JSON is nested too deep") from None
    if not isinstance(content, dict) or not isinstance(content.get("text"), str):
        raise ValueError('JSON must be {"text": TEXT} or {"text": TEXT, "unfinished": true}')
    return content["text"], content.get("unfinished") is True


def holds(reading: Reading) -> bool:
    """Return whether a text holds the arms, whatever words follow it."""
    return reading.command is not None and reading.command.word in ("stop", "pause")


def length_of(headers: Headers) -> int:
    """Return the length of a body.

    Raises:
        ValueError: The header is missing, or no whole number of digits.
    """
    said = headers.get("Content-Length", "")
    if not (said.isascii() and said.isdigit() and len(said) <= 18):
        raise ValueError(f"Content-Length {said[:40]!r} is no number of bytes")
    return int(said)


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Report no error of a client that has gone."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


def _handler(ask: Asks, gate: Gate) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        """Answers in JSON with the text's reading; the robot's reply stands in the page's log."""

        def handle(self) -> None:
            """Read one request; the rest of a request after `LIMIT_S` is ignored."""
            late = Timer(LIMIT_S, self._end_reading)
            late.daemon = True
            late.start()
            try:
                super().handle()
            finally:
                late.cancel()

        def _end_reading(self) -> None:
            with suppress(OSError):  # the client may have gone
                self.connection.shutdown(socket.SHUT_RD)

        def do_GET(self) -> None:
            """Send the page with the microphone."""
            if (why := gate.refusal(self.headers, self.path)) is not None:
                return self._answer(HTTPStatus.FORBIDDEN, {"error": why})
            if self.path.partition("?")[0] != "/":
                return self._answer(HTTPStatus.NOT_FOUND, {"error": "only / and /say are served"})
            return self._send(HTTPStatus.OK, PAGE.read_bytes(), "text/html; charset=utf-8")

        def do_POST(self) -> None:
            """Read the text, and submit it; submit an unfinished text only if it holds the arms."""
            if (why := gate.refusal(self.headers, self.path)) is not None:
                return self._answer(HTTPStatus.FORBIDDEN, {"error": why})
            if self.path.partition("?")[0] != "/say":
                return self._answer(HTTPStatus.NOT_FOUND, {"error": "only POST /say is served"})
            try:
                reading, unfinished = self._heard()
            except ValueError as error:
                return self._answer(HTTPStatus.BAD_REQUEST, {"error": str(error)})
            if not reading.text.strip():  # a recogniser heard silence
                return self._answer(HTTPStatus.OK, {"command": None, "reply": ""})
            if unfinished and not holds(reading):
                return self._answer(HTTPStatus.OK, {"command": None, "reply": ""})
            ask(SessionState.hear, reading)
            command = reading.command and reading.command.text
            return self._answer(HTTPStatus.OK, {"command": command, "reply": reading.reply})

        def _heard(self) -> tuple[Reading, bool]:
            """Return the reading of the body, and whether its speaker goes on."""
            length, kind = length_of(self.headers), self.headers.get("Content-Type", "")
            body = self.rfile.read(min(length, MOST_BYTES))
            if len(body) < min(length, MOST_BYTES):
                raise ValueError(f"only {len(body)} of {length} bytes came in {LIMIT_S:g} s")
            if length > MOST_BYTES:
                return too_long(body.decode("utf-8", "replace")), False
            text, unfinished = spoken_in(body, kind)
            return read(text), unfinished

        def _answer(self, status: HTTPStatus, content: dict[str, Any]) -> None:
            self._send(status, json.dumps(content).encode(), "application/json")

        def _send(self, status: HTTPStatus, body: bytes, kind: str) -> None:
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: Any) -> None:
            """Log nothing, because the run uses the terminal."""

    return Handler
