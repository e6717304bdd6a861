"""The interface of all panels, their HTML, and their style: CSS in addition to viser's own.

The HTML is written in `panels.html.jinja`, whose macros escape every text.
The style lays the correction buttons out as pads. A later viser may lack the classes that the style
names. Then the buttons stand one below the other with their whole texts, and work as before.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Sequence
from pathlib import Path
from typing import Any, Concatenate, ParamSpec

import viser

from scenarios.files.outside_text import templates
from scenarios.viewer.session_state import Asks, SessionState, State

LEFT_RGB, RIGHT_RGB = (0, 131, 148), (214, 106, 0)  # the arms' colours, dark enough under white

_FOLDER = Path(__file__).parent
_MACROS = templates(_FOLDER).get_template("panels.html.jinja").module

P = ParamSpec("P")


class Panel:
    """Part of the page, made by `Panel(gui, ask)` in viser's current container."""

    def update(self, state: State) -> None:
        """Show the session's state; viser sends only the changes. By default nothing changes."""


def html(macro: str, **shown: Any) -> str:
    """Return the HTML that a macro makes of what it shows."""
    return f'<div class="calot">{getattr(_MACROS, macro)(**shown)}</div>'


def asking(
    ask: Asks,
    method: Callable[Concatenate[SessionState, P], Any],
    *args: P.args,
    **kwargs: P.kwargs,
) -> Callable[[object], Coroutine[Any, Any, None]]:
    """Return what a button does when it is clicked: call a method of the session."""

    async def call(_: object) -> None:
        ask(method, *args, **kwargs)

    return call


def add_style(gui: viser.GuiApi, cells: str = "") -> None:
    """Add the style sheet to the page, with a panel's own rules for `cells`."""
    gui.add_html(f"<style>{(_FOLDER / 'panel.css').read_text()}{cells}</style>")


def pad(gui: viser.GuiApi, kind: str = "") -> None:
    """Lay out the buttons that follow in this folder as a pad."""
    gui.add_html(f'<span class="pad {kind}"></span>')


def cells(kind: str, places: Sequence[tuple[str, str]]) -> str:
    """Return CSS that puts the k-th button of a pad at a "row / column", with a short text."""
    rules = []
    for k, (place, text) in enumerate(places, start=2):
        cell = f"div:has(> div > .pad.{kind}) > div:nth-child({k})"
        rules.append(f"{cell} {{ grid-area: {place}; }}")
        rules.append(f'{cell} .mantine-Button-label::after {{ content: "{text}"; }}')
    return "\n".join(rules)
