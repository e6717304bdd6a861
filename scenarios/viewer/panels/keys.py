"""Keyboard shortcuts; Ctrl+K shows them on the page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import viser

from scenarios.viewer.panels.actions.talk import GO_ON, HOLD
from scenarios.viewer.session_state import Asks, SessionState


@dataclass(frozen=True, kw_only=True)
class Key:
    """A key and its action: submit a command, or call a method of the session."""

    hotkey: str
    label: str
    command: str | None = None
    method: Callable[[SessionState], None] | None = None
    shift: bool = False

    @property
    def shown(self) -> str:
        """Return the key's name for people to read."""
        return f"Shift+{self.hotkey}" if self.shift else self.hotkey


_DIRECTIONS = {  # keys of the right hand, placed like arrow keys
    "I": "higher",
    "J": "to the left",
    "K": "lower",
    "L": "to the right",
    "U": "away from me",
    "O": "towards me",
}
KEYS: tuple[Key, ...] = (
    Key(hotkey="space", label="start or pause", method=SessionState.start_or_pause),
    Key(hotkey="N", label="one step", method=SessionState.step),
    Key(hotkey="H", label="hold still", command=HOLD),
    Key(hotkey="B", label="back to the planner", command=GO_ON),
    *(
        Key(
            hotkey=key,
            label=f"move {arm} arm {words}",
            command=f"move {arm} arm {words}",
            shift=arm == "left",
        )
        for arm in ("right", "left")
        for key, words in _DIRECTIONS.items()
    ),
    *(
        Key(
            hotkey=key,
            label=f"{what} {arm} gripper",
            command=f"{what} {arm} gripper",
            shift=arm == "left",
        )
        for arm in ("right", "left")
        for key, what in (("Y", "open"), ("P", "close"))
    ),
)


def add_keys(gui: viser.GuiApi, ask: Asks) -> None:
    """Add all shortcuts to the page."""
    for key in KEYS:
        _add(gui, ask, key)


def _add(gui: viser.GuiApi, ask: Asks, key: Key) -> None:
    handle = gui.add_command(
        key.label,
        hotkey=key.hotkey,  # pyright: ignore[reportArgumentType]
        modifier="shift" if key.shift else None,
    )

    @handle.on_trigger
    async def _(_: object) -> None:
        if key.command is not None:
            ask(SessionState.press, key.command)
        elif key.method is not None:
            ask(key.method)
