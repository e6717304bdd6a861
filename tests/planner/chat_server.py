"""A local server of the chat-completions protocol that answers well or badly, as it is set."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from planner.procedure.cholecystectomy import TASKS

Answer = Callable[[BaseHTTPRequestHandler], None]


class ChatServer(ThreadingHTTPServer):
    """Gives its answers one after another, and then repeats the last one.

    Attributes:
        asked: bodies of the requests so far, parsed, with their headers under "headers".
        closing: set when the server closes, so that no handler hangs longer.
    """

    daemon_threads = True

    def __init__(self, answers: list[Answer]) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.answers, self.asked, self.closing = answers, [], threading.Event()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}/v1"


@contextmanager
def serving(*answers: Answer) -> Iterator[ChatServer]:
    with ChatServer(list(answers)) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield server
        finally:
            server.closing.set()
            server.shutdown()
            thread.join()


class _Handler(BaseHTTPRequestHandler):
    server: ChatServer

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"] or 0)) or "{}")
        self.server.asked.append({"path": self.path, "headers": dict(self.headers), **body})
        answers = self.server.answers
        (answers.pop(0) if len(answers) > 1 else answers[0])(self)

    do_GET = do_POST  # a redirection may turn a POST into a GET

    def log_message(self, *_: object) -> None:
        pass


def sends(
    content: bytes, status: int = 200, kind: str = "application/json", **headers: str
) -> Answer:
    """Return an answer that sends this content to any request."""

    def answer(handler: BaseHTTPRequestHandler) -> None:
        handler.send_response(status)
        handler.send_header("Content-Type", kind)
        handler.send_header("Content-Length", str(len(content)))
        for name, value in headers.items():
            handler.send_header(name, value)
        handler.end_headers()
        handler.wfile.write(content)

    return answer


def completes(text: object) -> Answer:
    """Return an answer that is a chat completion with this content."""
    return sends(json.dumps({"choices": [{"message": {"content": text}}]}).encode())


def says(task: object, correction: object = "none", **other: object) -> Answer:
    """Return an answer that is a completion of the planner's schema."""
    answer = {"reason": "as seen", "task": task, "correction": correction, "confidence": 0.9}
    return completes(json.dumps({**answer, **other}))


def hangs(handler: BaseHTTPRequestHandler) -> None:
    """Take the request and never answer."""
    handler.server.closing.wait(30)


def drips(handler: BaseHTTPRequestHandler) -> None:
    """Begin an answer and never end it: send a byte now and then."""
    handler.send_response(200)
    handler.send_header("Content-Type", "application/json")
    handler.end_headers()
    while not handler.server.closing.wait(0.05):
        handler.wfile.write(b" ")


def drips_headers(handler: BaseHTTPRequestHandler) -> None:
    """Begin an answer and send a byte of its headers now and then, each well within a timeout."""
    handler.wfile.write(b"HTTP/1.1 200 OK\r\nX-Wait: ")
    while not handler.server.closing.wait(0.05):
        handler.wfile.write(b".")


def refuses(name: str, status: int = 400, words: str | None = None) -> Answer:
    """Return an answer that refuses requests with this field, and else takes them."""
    words = f"unknown field {name}" if words is None else words

    def answer(handler: BaseHTTPRequestHandler) -> None:
        if name in handler.server.asked[-1]:
            fails(status, words)(handler)
        else:
            says(TASKS[0].text)(handler)

    return answer


def fails(status: int, words: str, **headers: str) -> Answer:
    """Return an answer with an error as OpenAI words it."""
    return sends(json.dumps({"error": {"message": words}}).encode(), status, **headers)


def hangs_up(handler: BaseHTTPRequestHandler) -> None:
    """Close the connection without an answer."""
    handler.close_connection = True
