"""Opens the page where it was asked for, and says where that is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console

from scenarios.viewer.desk import Desk
from scenarios.viewer.page import Page
from scenarios.viewer.port import FIRST_PORT, choose_port


@contextmanager
def open_page(desk: Desk, host: str, port: int | None, console: Console) -> Iterator[Page]:
    """The page, served while the block lasts.

    Raises:
        BadInputError: it cannot be served there.
    """
    free = choose_port(host, port)
    with Page(desk, host=host, port=free) as page:
        place = page.server.get_port()  # someone may have been faster
        if port is None and place != FIRST_PORT:
            console.print(f"port {FIRST_PORT} is taken: it is {place} instead")
        console.print(f"open http://{host}:{place} in a browser; Ctrl-C ends", highlight=False)
        yield page
