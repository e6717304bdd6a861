"""The server of a page: a viser server behind its gate, and a thread that draws."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import redirect_stdout
from io import StringIO
from threading import Event, Thread
from typing import Any, Self

import viser

from scenarios.viewer.serving.gate import Gate, guarded
from scenarios.viewer.serving.tab_messages import is_allowed

FRAME_S = 1.0 / 20.0  # from one update of a page's scene to the next, assumed


class DrawnPage(ABC):
    """Serves and draws while its `with` block lasts.

    Attributes:
        gate: Decides who may reach the page.
        server: The viser server.
    """

    def __init__(self, gate: Gate, *, host: str, port: int) -> None:
        """Serve at once; nothing is drawn before `__enter__`."""
        self._widgets: Mapping[str, Any] = {}
        with guarded(gate, self._accepts), redirect_stdout(StringIO()):  # hides viser's banner
            self.server = viser.ViserServer(host=host, port=port, label="Calot", verbose=False)
        self._widgets = self.server.gui._gui_input_handle_from_uuid  # viser has no other way
        self.gate = gate
        self._stop = Event()
        self._drawing = Thread(target=self._draw_on, name="calot-page", daemon=True)

    def __enter__(self) -> Self:
        self._drawing.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._stop.set()
        self._drawing.join()
        with redirect_stdout(StringIO()):
            self.server.stop()

    @property
    def port(self) -> int:
        """Return the port on which the page is served."""
        return self.server.get_port()

    @abstractmethod
    def draw(self) -> None:
        """Bring scene and panels up to date."""

    def _accepts(self, sent: str | bytes) -> bool:
        return is_allowed(sent, self._widgets)

    def _draw_on(self) -> None:
        while not self._stop.wait(FRAME_S):
            self.draw()
