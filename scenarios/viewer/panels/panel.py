"""What all panels share."""

from __future__ import annotations

from typing import Protocol

from scenarios.viewer.chronicle import Story


class Panel(Protocol):
    """Part of the page: made as `Panel(gui, desk)` in viser's current container."""

    def update(self, story: Story) -> None:
        """Show how things stand; what has not changed is not sent."""
        ...
