"""The interface of all panels."""

from __future__ import annotations

from typing import Protocol

from scenarios.viewer.session_state import State


class Panel(Protocol):
    """Part of the page, made by `Panel(gui, ask)` in viser's current container."""

    def update(self, state: State) -> None:
        """Show the session's state; viser sends only the changes."""
        ...
