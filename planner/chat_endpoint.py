"""Describe a language model's endpoint, and send it one HTTP request within a time limit.

The protocol is that of OpenAI's chat completions. The whole reply comes within the limit, however
slow the endpoint is.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPException
from socket import SHUT_RDWR
from threading import Thread
from typing import Any
from urllib.parse import unquote, urlsplit
from urllib.request import HTTPHandler, HTTPSHandler, OpenerDirector, ProxyHandler, Request

URL, MODEL, KEY = "CALOT_LLM_URL", "CALOT_LLM_MODEL", "CALOT_LLM_KEY"
TIMEOUT, TIMEOUT_S = "CALOT_LLM_TIMEOUT", 10.0  # the variable, and its default


class EndpointError(RuntimeError):
    """No model answers: the endpoint is down, refuses, or breaks the protocol; in one line.

    Attributes:
        passing: Whether the error may be over at the next request.
        after_s: Waiting time that the endpoint wants; 0 if the endpoint names none.
    """

    def __init__(self, why: str, *, passing: bool = True, after_s: float = 0.0) -> None:
        super().__init__(why)
        self.passing, self.after_s = passing, after_s


@dataclass(frozen=True, kw_only=True)
class Endpoint:
    """The address of a model, and its settings.

    Attributes:
        url: Base of the API, to which "/chat/completions" is added.
        model: Name of the model at the endpoint.
        key: Key that is sent as a bearer token; "" for none. No file and no message has the key.
        timeout_s: Wall-clock time for a whole answer, including all repeated requests.

    Raises:
        ValueError: The address is not an http or https address, the model is missing, or the time
            is not above 0.
    """

    url: str
    model: str
    key: str = ""
    timeout_s: float = TIMEOUT_S

    def __post_init__(self) -> None:
        if not _is_address(self.url):
            raise ValueError(
                f"{URL} must be an address like https://host/v1, in ASCII, got {self.url!r}"
            )
        if not self.model:
            raise ValueError(f"{MODEL} must name a model")
        if not (self.key.isascii() and self.key.isprintable()):
            raise ValueError(f"{KEY} must be printable ASCII")
        if not 0.0 < self.timeout_s < math.inf:
            raise ValueError(f"{TIMEOUT} must be a number of seconds above 0, got {self.timeout_s}")

    @property
    def name(self) -> str:
        """Return the model and the host for a person to read, without the rest of the address."""
        return f"{self.model} at {urlsplit(self.url).hostname}"

    def __repr__(self) -> str:
        return f"Endpoint({self.name})"


def endpoint_from_environment() -> Endpoint:
    """Return the endpoint that `URL`, `MODEL` and, if wanted, `KEY` and `TIMEOUT` name.

    Raises:
        ValueError: A variable is missing or wrong. The message is one line.
    """
    if missing := [name for name in (URL, MODEL) if not os.environ.get(name)]:
        raise ValueError(
            f"planner 'llm' needs an endpoint: set {' and '.join(missing)}"
            f" (an address like https://host/v1, a model's name), and {KEY} where it wants a key"
        )
    return Endpoint(
        url=os.environ[URL],
        model=os.environ[MODEL],
        key=os.environ.get(KEY, "").strip(),
        timeout_s=_seconds(os.environ.get(TIMEOUT) or str(TIMEOUT_S)),
    )


def _seconds(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{TIMEOUT} must be a number of seconds, got {text!r}") from None


def _is_address(url: str) -> bool:
    """Return whether a request can be sent to this address.

    urllib decodes the host, takes a user before the host for a part of it, and sends ASCII only.
    """
    try:
        parts = urlsplit(url)
        host = unquote(parts.hostname or "")
        known = parts.scheme in ("http", "https") and host.encode("idna") and parts.port != 0
    except ValueError:
        return False
    is_plain = (url + host).isascii() and url.isprintable() and " " not in url
    return bool(known) and is_plain and "@" not in parts.netloc


# One request

MAX_BYTES = 1_000_000
MAX_WORDS = 200  # characters of a server's words that are reported
THREAD = "request to a language model"


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
    """Send a request and return the whole reply; a redirect is a reply, too.

    Raises:
        TimeoutError: The whole reply did not come within the limit.
        EndpointError: The server cannot be reached, or sends too much.
    """
    request, line = Request(address, body, dict(headers), method="POST"), _Line()
    future: Future[Reply] = Future()

    def run() -> None:
        try:
            future.set_result(line.exchange(request, limit_s))
        except Exception as error:
            future.set_exception(error)

    Thread(target=run, name=THREAD, daemon=True).start()
    try:  # the timeout of a socket limits each read, and the look-up of a name has no timeout
        return future.result(timeout=max(limit_s, 0.0))
    except TimeoutError:
        line.hang_up()
        raise
    except (OSError, HTTPException) as error:
        reason = getattr(error, "reason", None) or error
        if isinstance(reason, TimeoutError):
            raise TimeoutError from None
        raise EndpointError(f"it cannot be reached: {reason}") from None


class _Line(HTTPSHandler, HTTPHandler):
    """Opens one connection, which another thread can cut."""

    _connection: HTTPConnection | None = None

    def do_open(self, http_class: Any, req: Request, **options: Any) -> Any:
        """Connect as usual, and keep the connection."""

        def connection(host: str, **more: Any) -> HTTPConnection:
            self._connection = made = http_class(host, **more)
            return made

        return super().do_open(connection, req, **options)  # pyright: ignore[reportArgumentType]

    def exchange(self, request: Request, limit_s: float) -> Reply:
        """Send a request, without following redirects: the named address alone gets the key."""
        opener, until_s, content = OpenerDirector(), time.monotonic() + limit_s, b""
        for handler in (ProxyHandler(), self):
            opener.add_handler(handler)
        answer: Any = opener.open(request, timeout=limit_s)
        with answer:
            while part := answer.read1(65_536):
                content += part
                if len(content) > MAX_BYTES:
                    raise EndpointError(f"its answer is longer than {MAX_BYTES} bytes")
                if time.monotonic() > until_s:
                    raise TimeoutError
        return Reply(
            status=answer.status, reason=answer.reason, headers=answer.headers, content=content
        )

    def hang_up(self) -> None:
        """Cut the connection if it is open, so that the thread that reads from it ends."""
        if self._connection is not None and self._connection.sock is not None:
            with suppress(OSError):
                self._connection.sock.shutdown(SHUT_RDWR)
