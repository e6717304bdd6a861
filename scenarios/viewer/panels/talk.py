"""Panel for free text: shows at once how a text was read, or asks back if it is unclear."""

from __future__ import annotations

import time
from typing import Any

import viser

from scenarios.loop.person.inbox import read
from scenarios.recording.event_log import Kind, LogLine
from scenarios.viewer.panels.panel import Panel, asking, html, pad
from scenarios.viewer.session_state import Asks, SessionState, State

LATE_S = 0.5  # how long to wait for typed text that arrives after Enter
SHOWN = 120  # characters of the text
HOLD, GO_ON = "pause", "resume"  # commands of the two buttons
SPOKEN: tuple[Kind, ...] = ("said", "asked back", "told")
_NONE = "-"


class TalkPanel(Panel):
    """A line for free text, buttons for the guesses, and buttons to hold and to go on."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._ask = ask
        self._shown: LogLine | None = None
        with gui.add_folder("Tell the robot"):
            pad(gui, "two")
            form = gui.add_form(None)
            with form:
                self._text = gui.add_text("say", "", hint="in your own words; Enter sends it")
            self._reply = gui.add_html(_reply("example"))
            self._guesses = gui.add_button_group("did you mean", (_NONE,), visible=False)
            hold = gui.add_button("Hold still", icon=viser.Icon.HAND_STOP, color="red")
            on = gui.add_button("Back to planner", icon=viser.Icon.ROBOT, color="green")
        form.on_submit(self._on_submit)
        self._guesses.on_click(self._on_guess)
        hold.on_click(asking(ask, SessionState.press, HOLD))
        on.on_click(asking(ask, SessionState.press, GO_ON))

    def _on_submit(self, _: object) -> None:
        """Read the text; viser calls this in a separate thread, so it may take time."""
        text = self._typed()
        self._text.value = ""
        reading = read(text)
        self._ask(SessionState.hear, reading)
        self._reply.content = _reply("read", reading=reading, most=SHOWN)
        unclear = bool(reading.guesses)
        if unclear:
            self._guesses.options = tuple(guess.text for guess in reading.guesses)
        self._guesses.visible = unclear

    def _typed(self) -> str:
        """Return the typed text; a busy page sends it after Enter, so wait for it."""
        end_s = time.monotonic() + LATE_S
        while not self._text.value and time.monotonic() < end_s:
            time.sleep(0.01)
        return self._text.value

    async def _on_guess(self, _: object) -> None:
        if self._guesses.value != _NONE:
            self._ask(SessionState.hear, read(self._guesses.value))
            self._guesses.visible = False
            self._reply.content = _reply("guess", text=self._guesses.value)

    def update(self, state: State) -> None:
        """Show the robot's newest reply, which describes the arms' current action."""
        spoken = [line for line in state.status.lines if line.kind in SPOKEN]
        if spoken and spoken[-1] != self._shown:
            self._shown = spoken[-1]
            self._reply.content = _reply("spoken", line=self._shown)


def _reply(macro: str, **shown: Any) -> str:
    return f'<div class="reply">{html(macro, **shown)}</div>'
