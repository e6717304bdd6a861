"""Opens a page where it was asked for, and says where that is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console

from scenarios.viewer.port import FIRST_PORT, choose_port


class Served(Protocol):
    """A page with its server, up while its `with` block lasts."""

    @property
    def port(self) -> int: ...
    def __enter__(self) -> Served: ...
    def __exit__(self, *exception: object) -> None: ...


@contextmanager
def serve(
    make: Callable[[int], Served], host: str, port: int | None, console: Console
) -> Iterator[None]:
    """Makes a page on a port, and serves it while the block lasts.

    Raises:
        BadInputError: it cannot be served there.
    """
    with make(choose_port(host, port)) as page:
        if port is None and page.port != FIRST_PORT:  # someone may have been faster
            console.print(f"port {FIRST_PORT} is taken: it is {page.port} instead", highlight=False)
        console.print(f"open http://{host}:{page.port} in a browser; Ctrl-C ends", highlight=False)
        yield
