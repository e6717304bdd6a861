"""Serve a page on a port, and print its address."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from scenarios.files.outside_text import Terminal
from scenarios.viewer.serving.gate import Gate
from scenarios.viewer.serving.port import FIRST_PORT, choose_port, in_address


class Served(Protocol):
    """A page whose server runs while its `with` block lasts."""

    @property
    def gate(self) -> Gate: ...
    @property
    def port(self) -> int: ...
    def __enter__(self) -> Served: ...
    def __exit__(self, *exception: object) -> None: ...


@contextmanager
def serve(
    make: Callable[[int], Served],
    host: str,
    port: int | None,
    console: Terminal,
    say_port: int | None = None,
) -> Iterator[None]:
    """Serve a page while the block lasts; the microphone's page, if any, is on `say_port`.

    Raises:
        BadInputError: The page cannot be served on this port.
    """
    with make(choose_port(host, port, say_port=say_port)) as page:
        if port is None and page.port != FIRST_PORT:
            console.print(f"port {FIRST_PORT} is taken; using {page.port}", highlight=False)
        token = page.gate.token
        if token:
            warning = "warning: others can reach this address; who has it can move the robot"
            console.print(warning, highlight=False, soft_wrap=True)
        asked = f"/?token={token}" if token else ""
        told = (
            f"open http://{in_address(host)}:{page.port}{asked} in a browser; press Ctrl-C to end"
        )
        console.print(told, highlight=False, soft_wrap=True)
        if say_port is not None:
            told = f"speak at http://{in_address(host)}:{say_port}{asked}"
            console.print(told, highlight=False, soft_wrap=True)
        yield
