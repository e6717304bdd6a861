"""Keyboard shortcuts; Ctrl+K shows them on the page, too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import viser

from scenarios.viewer.panels.talk import GO_ON, HOLD
from scenarios.viewer.session_state import Asks, SessionState


@dataclass(frozen=True, kw_only=True)
class Key:
    """A key and what it does: says a command, or does a deed at the desk."""

    hotkey: str
    label: str
    command: str | None = None
    deed: Callable[[SessionState], None] | None = None
    shift: bool = False

    @property
    def shown(self) -> str:
        """As people read it."""
        return f"Shift+{self.hotkey}" if self.shift else self.hotkey


_RIGHT_HAND = {  # as arrow keys lie, with those beside them
    "I": "higher",
    "J": "to the left",
    "K": "lower",
    "L": "to the right",
    "U": "away from me",
    "O": "towards me",
}
KEYS: tuple[Key, ...] = (
    Key(hotkey="space", label="start or pause", deed=SessionState.start_or_pause),
    Key(hotkey="N", label="one step", deed=SessionState.step),
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
        for key, words in _RIGHT_HAND.items()
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
    """Have the page listen to them."""
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
        elif key.deed is not None:
            ask(key.deed)
