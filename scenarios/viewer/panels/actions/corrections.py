"""The 18 corrections as buttons, laid out by arm and direction in the endoscope's view."""

from __future__ import annotations

import viser

from planner.correction import CORRECTIONS, Correction
from scenarios.viewer.panels.style import LEFT_RGB, RIGHT_RGB, cells, pad
from scenarios.viewer.session_state import Asks, SessionState, State

_PLACES = {  # direction or jaw: the button's "row / column", and its short text
    "higher": ("1 / 2", "▲ higher"),
    "left": ("2 / 1", "◀ left"),
    "right": ("2 / 3", "right ▶"),
    "lower": ("3 / 2", "▼ lower"),
    "away": ("1 / 1", "⬈ away"),
    "towards": ("3 / 1", "⬋ towards"),
    "open": ("1 / 3", "open"),
    "close": ("3 / 3", "close"),
}
CELLS = cells("arm", tuple(_PLACES.values()))
_PADS = (
    ("left", "Left arm: grasper", LEFT_RGB),
    ("right", "Right arm: clip applier, scissors", RIGHT_RGB),
)


class CorrectionPanel:
    """A pad of buttons for each arm, and buttons for the jaws of both."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._ask = ask
        for arm, title, colour in _PADS:
            with gui.add_folder(title):
                pad(gui, "arm short")
                for what in _PLACES:
                    self._add(gui, _correction(arm, what), colour)
        with gui.add_folder("Both"):
            pad(gui, "two")
            for what in ("open", "close"):
                self._add(gui, _correction("both", what), (90, 90, 100))

    def _add(self, gui: viser.GuiApi, correction: Correction, colour: tuple[int, int, int]) -> None:
        button = gui.add_button(correction.text, color=colour)

        @button.on_click
        async def _(_: object) -> None:
            self._ask(SessionState.press, correction.text)

    def update(self, state: State) -> None:
        """Do nothing: the panel never changes."""


def _correction(arm: str, what: str) -> Correction:
    return next(c for c in CORRECTIONS if c.arm == arm and what in (c.direction, c.jaw))
