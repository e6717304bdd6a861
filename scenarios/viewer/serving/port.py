"""Choose a free port to serve a page on."""

from __future__ import annotations

import os
import socket

from scenarios.files.errors import BadInputError

FIRST_PORT = 8080
PORTS = 100  # number of ports to try
OTHERWISE = {"--port": "leave out --port to use a free one", "--say-port": "name a free one"}


def choose_port(
    host: str, asked: int | None = None, option: str = "--port", say_port: int | None = None
) -> int:
    """Return the port that `option` requests, or the first free one from `FIRST_PORT` on.

    `say_port` is not free: the page with the microphone is served there.

    Raises:
        BadInputError: The requested port or all ports are taken, or `host` is not this machine's.
    """
    try:
        family_of(host)
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or "it is no name of a machine"
        raise BadInputError(f"--host {host}: {why}; name an address of this machine") from None
    if asked is not None:
        if asked == say_port:
            raise BadInputError(f"{option} {asked}: --say-port is the same; {OTHERWISE[option]}")
        if error := _why_not(host, asked):
            raise BadInputError(f"{option} {asked}: {error}; {OTHERWISE[option]}")
        return asked
    ports = [port for port in range(FIRST_PORT, FIRST_PORT + PORTS) if port != say_port]
    for port in ports:
        if not (error := _why_not(host, port)):
            return port
    raise BadInputError(
        f"--host {host}: no port from {ports[0]} to {ports[-1]} can be used: {error}"
    )


def family_of(host: str) -> socket.AddressFamily:
    """Return whether a server listens there by IPv4 or IPv6.

    Raises:
        OSError, UnicodeError: There is no such host.
    """
    return socket.getaddrinfo(host, None)[0][0]


def in_address(host: str) -> str:
    """Return the host as part of a web address: an IPv6 host in brackets."""
    return f"[{host}]" if ":" in host else host


def _why_not(host: str, port: int) -> str | None:
    """Return the reason why a server cannot listen on this port; None if it can."""
    try:
        with socket.create_server((host, port), family=family_of(host)):
            return None
    except OverflowError:
        return "no port is above 65535"
    except OSError as error:
        return os.strerror(error.errno) if error.errno and error.errno > 0 else str(error)
