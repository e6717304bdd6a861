"""Access to the page: for this machine's own pages, and for clients with the token.

Any website that a browser shows may open a WebSocket to this machine; only its `Origin`
distinguishes it from the page (RFC 6455, section 10.2). A name that an attacker points at this
machine passes for the same origin, so `Host` is checked as well. A tab that floods the page is read
no faster than a person acts, so that this tab waits and the others do not.
"""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from email.message import Message
from functools import partial
from http import HTTPStatus
from http.cookies import SimpleCookie
from time import monotonic
from typing import Any
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import ServerConnection
from websockets.frames import CloseCode

LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})
COOKIE = "calot"
MOST_PER_S, BURST = 200, 600  # messages from a tab; viser's page sends 20 to 60 a second; assumed
MOST_BYTES = 2**20  # of a message; a person's text is far shorter
Accepts = Callable[[str | bytes], bool]
Headers = Mapping[str, str] | Message  # the servers' own headers, which ignore the case of names


@dataclass(frozen=True, kw_only=True)
class Gate:
    """Decides on requests by their headers.

    Attributes:
        token: The token that a client must present, in the address or in the cookie that the page
            sets then. "" on an address that only this machine can reach.
    """

    token: str = ""

    def refusal(self, headers: Headers, path: str) -> str | None:
        """Return the reason why a request is refused; None if the request may pass."""
        host, origin = headers.get("Host", ""), headers.get("Origin")
        if not self.token and _name(f"//{host}") not in LOOPBACK:
            return f"host {host!r} is not this machine"
        if origin is not None and urlsplit(origin).netloc != host:
            return f"origin {origin!r} is not this page"
        if self.token and not self._is_known(headers, path):
            return "the token of the printed address is missing"
        return None

    def _is_known(self, headers: Headers, path: str) -> bool:
        cookie = SimpleCookie(headers.get("Cookie", "")).get(COOKIE)
        said = [*parse_qs(urlsplit(path).query).get("token", []), cookie.value if cookie else ""]
        return any(secrets.compare_digest(one.encode(), self.token.encode()) for one in said)

    def before(self, process: Callable[[Any, Any], Any] | None) -> Callable[[Any, Any], Any]:
        """Return a function that answers a request of `websockets` by a refusal or by `process`."""

        def answer(connection: Any, request: Any) -> Any:
            if (why := self.refusal(request.headers, request.path)) is not None:
                return connection.respond(HTTPStatus.FORBIDDEN, f"Calot: {why}\n")
            response = process(connection, request) if process else None
            if response is not None and self.token:
                response.headers["Set-Cookie"] = f"{COOKIE}={self.token}; HttpOnly; SameSite=Strict"
            return response

        return answer


def gate_for(host: str) -> Gate:
    """Return the gate for an address to listen on, with a new token beyond this machine."""
    return Gate(token="" if host in LOOPBACK else secrets.token_urlsafe(16))


class Paced(ServerConnection):
    """A connection of which at most `MOST_PER_S` messages are read, after a burst of `BURST`.

    Unread messages fill the sender's own buffers. A message that is not accepted ends the
    connection.
    """

    _free_at_s = 0.0

    def __init__(self, *args: Any, accepts: Accepts, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self._accepts = accepts

    async def recv(self, decode: bool | None = None) -> Any:
        """Return the next message that is accepted, in its time."""
        while not self._accepts(message := await self._in_time(decode)):
            await self.close(CloseCode.POLICY_VIOLATION, "the page sends no such message")
        return message

    async def _in_time(self, decode: bool | None) -> Any:
        message = await super().recv(decode)
        earliest_s = monotonic() - BURST / MOST_PER_S
        self._free_at_s = max(self._free_at_s, earliest_s) + 1.0 / MOST_PER_S
        if (wait_s := self._free_at_s - monotonic()) > 0.0:
            await asyncio.sleep(wait_s)
        return message


@contextmanager
def guarded(gate: Gate, accepts: Accepts = lambda _: True) -> Iterator[None]:
    """Put the gate before every `websockets` server that is started while the block lasts.

    Its connections are `Paced`, and end with a message that is not accepted, or is too large.

    The function replaces `serve`, because viser has no setting for a gate.
    """
    from websockets.asyncio import server

    serve = server.serve

    def serve_guarded(*args: Any, process_request: Any = None, **settings: Any) -> Any:
        settings |= {
            "process_request": gate.before(process_request),
            "create_connection": partial(Paced, accepts=accepts),
            "max_size": MOST_BYTES,
        }
        return serve(*args, **settings)

    server.serve = serve_guarded  # pyright: ignore[reportAttributeAccessIssue]
    try:
        yield
    finally:
        server.serve = serve  # pyright: ignore[reportAttributeAccessIssue]


def _name(address: str) -> str:
    try:
        return urlsplit(address).hostname or ""
    except ValueError:
        return ""
