"""Hostile clients of the page: they send anything, break off, or never end.

Each fault goes to a page of its own process, over a socket on 127.0.0.1. A page survives a fault if
it answers or cuts it off in time, and the next client, a plain "stop", is still read.
"""

from __future__ import annotations

import json
import socket
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from scenarios.catalogue import ORACLE
from scenarios.commands.browser import new_session
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.viewer.serving.page_process import PageProcess
from scenarios.viewer.serving.port import choose_port
from scenarios.viewer.serving.say_server import MOST_BYTES

HOST = "127.0.0.1"
LOADING_S = 60.0
MOST_S = 5.0  # limit of an answer; a client that sends half a request waits and then leaves
ANSWERS = (200, 400, 403, 404, 408, 413, 414, 431, 501, 505)

Rng = np.random.Generator


@dataclass(frozen=True, kw_only=True)
class Client:
    """The bytes that a client sends, and whether they are a whole request."""

    sent: bytes
    is_whole: bool = True


def page_faults(seed: int, n: int) -> Counter[str]:
    """Return how many of `n` hostile clients ended in which way: "KIND: OUTCOME"."""
    rng = np.random.default_rng(seed)
    kinds = list(CLIENTS.items())
    counts = Counter[str]()
    with TemporaryDirectory(prefix="calot-page-") as out:
        port = choose_port(HOST)
        say_port = choose_port(HOST, say_port=port)
        config = EpisodeConfig(**ORACLE, seed=0)
        session = new_session(config, Path(out), paused=True, restarts=True, camera=False)
        with PageProcess(session, host=HOST, port=port, say_port=say_port):
            first = _post(b"qqqq the left arm higher")  # loads what reads it: seconds, once
            _sent(say_port, first, within_s=LOADING_S)
            for _ in range(n):
                name, make = kinds[rng.integers(len(kinds))]
                outcome = _sent(say_port, make(rng))
                if _sent(say_port, _post(b"stop")) != "answered":
                    outcome = "page lost"
                counts[f"{name}: {outcome}"] += 1
    return counts


def _sent(port: int, client: Client, within_s: float = MOST_S) -> str:
    """Return "answered", "left" (half a request), "closed", "hung" or "odd answer"."""
    end_s = time.monotonic() + within_s
    try:
        with socket.create_connection((HOST, port), timeout=within_s) as connection:
            connection.sendall(client.sent)
            if not client.is_whole:
                return "left"
            words = connection.makefile("rb").readline().split()
    except TimeoutError:
        return "hung"
    except OSError:
        return "closed"
    if time.monotonic() > end_s:
        return "hung"
    is_status = len(words) > 1 and words[1].isdigit() and int(words[1]) in ANSWERS
    return "answered" if is_status else "odd answer" if words else "closed"


def _post(body: bytes, *headers: str, kind: str = "text/plain", length: str = "") -> Client:
    head = [f"POST /say HTTP/1.1\r\nHost: {HOST}", f"Content-Type: {kind}", *headers]
    head.append(f"Content-Length: {length or len(body)}")
    return Client(sent="\r\n".join(head).encode("latin-1", "replace") + b"\r\n\r\n" + body)


def _noise(rng: Rng) -> bytes:
    return rng.bytes(int(rng.integers(1, 2000)))


def _json_of(rng: Rng) -> Client:
    texts = ("[" * 4099, "{" * 9000, '{"text": "\\ud800"}', '{"text": 1e999}', "NaN", '{"text": ')
    return _post(str(rng.choice(texts)).encode(), kind="application/json")


def _length(rng: Rng) -> Client:
    lengths = ("x", "-1", "1.5", "\xb2", "9" * 5000, "0x4", " ")
    return _post(b"stop", length=str(rng.choice(lengths)))


def _edited(rng: Rng) -> Client:
    """Return a good request with some bytes changed."""
    request = bytearray(_post(json.dumps({"text": "stop"}).encode(), kind="application/json").sent)
    for at in rng.integers(len(request), size=int(rng.integers(1, 6))):
        request[at] = int(rng.integers(256))
    return Client(sent=bytes(request) + b"\r\n\r\n", is_whole=False)


CLIENTS: dict[str, Callable[[Rng], Client]] = {
    "noise as a body": lambda rng: _post(_noise(rng)),
    "noise as a request": lambda rng: Client(sent=_noise(rng) + b"\r\n\r\n", is_whole=False),
    "bad JSON": _json_of,
    "bad length": _length,
    "too long": lambda rng: _post(b"a" * int(rng.integers(1, 3) * MOST_BYTES)),
    "half a body": lambda rng: Client(sent=_post(b"st", length="9").sent, is_whole=False),
    "an edited request": _edited,
    "foreign origin": lambda rng: _post(b"stop", "Origin: https://evil.example"),
}
