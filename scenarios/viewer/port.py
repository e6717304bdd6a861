"""Where the page is served: a port that is free."""

from __future__ import annotations

import os
import socket

from scenarios.files.errors import BadInputError

FIRST_PORT = 8080
PORTS = 100  # how many are tried


def choose_port(host: str, asked: int | None = None) -> int:
    """The port that was asked for, else the first free one from `FIRST_PORT` on.

    Raises:
        BadInputError: it is taken, all are, or the address is none of this machine's.
    """
    if asked is not None:
        if error := _why_not(host, asked):
            raise BadInputError(f"--port {asked}: {error}; leave it out for the next free one")
        return asked
    ports = range(FIRST_PORT, FIRST_PORT + PORTS)
    for port in ports:
        if not (error := _why_not(host, port)):
            return port
    raise BadInputError(f"--host {host}: no port of {ports[0]} to {ports[-1]} is free: {error}")


def _why_not(host: str, port: int) -> str | None:
    """Why a server cannot listen there; None if it can."""
    try:
        with socket.create_server((host, port)):
            return None
    except (OSError, OverflowError) as error:
        number = getattr(error, "errno", None) or 0
        return os.strerror(number) if number > 0 else str(error)
