"""`POST /say`: a person at the microphone page, or any program, speaks to the episode."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from threading import Thread
from typing import Any

from planner.language.reading import Reading
from scenarios.loop.person.inbox import LONGEST, read
from scenarios.viewer.serving.gate import Gate
from scenarios.viewer.serving.port import family_of
from scenarios.viewer.session_state import Asks, SessionState

PAGE = files("scenarios.viewer").joinpath("microphone.html")
MOST_BYTES = 4 * LONGEST + 100  # of a body: UTF-8, and the JSON around it


@contextmanager
def say_server(ask: Asks, gate: Gate, *, host: str, port: int) -> Iterator[None]:
    """Serve `POST /say`, and the page with the microphone, while the block lasts."""
    kind = type("Server", (ThreadingHTTPServer,), {"address_family": family_of(host)})
    server = kind((host, port), _handler(ask, gate))
    Thread(target=server.serve_forever, name="calot-say", daemon=True).start()
    try:
        yield
    finally:
        server.shutdown()
        server.server_close()


def spoken_in(body: bytes, kind: str) -> tuple[str, bool]:
    """Return the text of a body, plain or JSON {"text": TEXT}, and whether its speaker goes on.

    A recogniser that hears more says so: {"text": TEXT, "unfinished": true}.

    Raises:
        ValueError: it is neither.
    """
    if "json" not in kind:
        return body.decode("utf-8"), False
    content = json.loads(body)
    if not isinstance(content, dict) or not isinstance(content.get("text"), str):
        raise ValueError('JSON must be {"text": TEXT} or {"text": TEXT, "unfinished": true}')
    return content["text"], content.get("unfinished") is True


def holds(reading: Reading) -> bool:
    """Return whether a text holds the arms, whatever else is said after it."""
    return reading.command is not None and reading.command.word in ("stop", "pause")


def _handler(ask: Asks, gate: Gate) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        """Answers in JSON how the text is read; the robot's reply stands in the page's log."""

        def do_GET(self) -> None:
            """Send the page with the microphone."""
            if (why := gate.refusal(self.headers, self.path)) is not None:
                return self._answer(HTTPStatus.FORBIDDEN, {"error": why})
            if self.path.partition("?")[0] != "/":
                return self._answer(HTTPStatus.NOT_FOUND, {"error": "only / and /say are served"})
            return self._send(HTTPStatus.OK, PAGE.read_bytes(), "text/html; charset=utf-8")

        def do_POST(self) -> None:
            """Read the text, and submit it; of an unfinished one, only what holds the arms."""
            if (why := gate.refusal(self.headers, self.path)) is not None:
                return self._answer(HTTPStatus.FORBIDDEN, {"error": why})
            if self.path.partition("?")[0] != "/say":
                return self._answer(HTTPStatus.NOT_FOUND, {"error": "only POST /say is served"})
            length = self.headers.get("Content-Length", "")
            if not length.isdigit() or int(length) > MOST_BYTES:
                why = f"a body of at most {MOST_BYTES} bytes, with its length, is needed"
                return self._answer(HTTPStatus.BAD_REQUEST, {"error": why})
            try:
                kind = self.headers.get("Content-Type", "")
                text, unfinished = spoken_in(self.rfile.read(int(length)), kind)
            except ValueError as error:
                return self._answer(HTTPStatus.BAD_REQUEST, {"error": str(error)})
            reading = read(text)
            if unfinished and not holds(reading):
                return self._answer(HTTPStatus.OK, {"command": None, "reply": ""})
            ask(SessionState.hear, reading)
            command = reading.command and reading.command.text
            return self._answer(HTTPStatus.OK, {"command": command, "reply": reading.reply})

        def _answer(self, status: HTTPStatus, content: dict[str, Any]) -> None:
            self._send(status, json.dumps(content).encode(), "application/json")

        def _send(self, status: HTTPStatus, body: bytes, kind: str) -> None:
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: Any) -> None:
            """Keep the terminal for the run."""

    return Handler
