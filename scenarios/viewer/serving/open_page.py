"""Serve a page on a port, and print its address."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from scenarios.files.outside_text import Terminal
from scenarios.viewer.serving.port import FIRST_PORT, choose_port, in_address

if TYPE_CHECKING:
    from scenarios.viewer.serving.drawn_page import DrawnPage
    from scenarios.viewer.serving.page_process import PageProcess


@contextmanager
def serve(
    make: Callable[[int], PageProcess | DrawnPage],
    host: str,
    port: int | None,
    say_port: int | None = None,
) -> Iterator[None]:
    """Serve a page while the block lasts; the microphone's page, if any, is on `say_port`.

    Raises:
        BadInputError: The page cannot be served on this port.
    """
    console = Terminal(stderr=True)
    with make(choose_port(host, port, say_port=say_port)) as page:
        if port is None and page.port != FIRST_PORT:
            console.print(f"port {FIRST_PORT} is taken; using {page.port}")
        token = page.gate.token
        if token:
            warning = "warning: others can reach this address; who has it can move the robot"
            console.print(warning, soft_wrap=True)
        asked = f"/?token={token}" if token else ""
        here = f"http://{in_address(host)}"
        told = [f"open {here}:{page.port}{asked} in a browser; press Ctrl-C to end"]
        told += [] if say_port is None else [f"speak at {here}:{say_port}{asked}"]
        for line in told:
            console.print(line, soft_wrap=True)
        yield
