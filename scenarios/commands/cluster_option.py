"""`--cluster`: check before any work that the Ray cluster can do it."""

import re
import socket
from importlib.util import find_spec
from pathlib import Path

from scenarios.files.errors import BadInputError, describe_error

ANSWERS_WITHIN_S = 10.0

# RFC 9113, 3.4 and 4.1: an HTTP/2 client, as Ray's is, begins with this preface, which ends in an
# empty SETTINGS frame. An HTTP/2 server also begins with a SETTINGS frame: its fourth byte says so.
_PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, 4, 0, 0, 0, 0, 0])
_FRAME_TYPE, _SETTINGS = 3, 4


def require_cluster(address: str | None, *folders: Path) -> None:
    """Join the Ray cluster at HOST:PORT, if one is given.

    All its nodes must see `folders` and the current folder, so that paths mean the same everywhere.

    Raises:
        BadInputError: Ray is missing, nothing answers, or a node cannot do the work.
    """
    if address is None:
        return
    if find_spec("ray") is None:
        raise BadInputError("--cluster needs Ray: .venv/bin/pip install -e '.[cluster]'")
    _require_answer(address)
    from scenarios.workers.ray_workers import connect, obstacles

    try:
        connect(address)
    except (ConnectionError, RuntimeError, ValueError) as error:
        why = " ".join(describe_error(error).split())
        raise BadInputError(f"--cluster {address}: cannot join it: {why}") from None
    for obstacle in obstacles([Path(), *folders]):
        raise BadInputError(f"--cluster {address}: {obstacle}")


def _require_answer(address: str) -> None:
    """Check the address directly; Ray itself takes minutes to notice that nothing answers."""
    if not (parts := re.fullmatch(r"([\w.-]+):(\d{1,5})", address)):
        raise BadInputError(f"--cluster: {address!r} is not HOST:PORT")
    try:
        there = (parts[1], int(parts[2]))
        with socket.create_connection(there, timeout=ANSWERS_WITHIN_S) as connection:
            connection.sendall(_PREFACE)
            head = connection.recv(9)
    except (OSError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or error
        raise BadInputError(f"--cluster {address}: no answer ({reason})") from None
    if len(head) <= _FRAME_TYPE or head[_FRAME_TYPE] != _SETTINGS:
        raise BadInputError(f"--cluster {address}: the server there is not Ray")
