"""What all panels share."""

from __future__ import annotations

from typing import Protocol

from scenarios.viewer.session_state import State


class Panel(Protocol):
    """Part of the page: made as `Panel(gui, ask)` in viser's current container."""

    def update(self, state: State) -> None:
        """Show how things stand; what has not changed is not sent."""
        ...
