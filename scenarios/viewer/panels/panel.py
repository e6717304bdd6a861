"""The interface of all panels, and their style: CSS in addition to viser's own.

The style lays the correction buttons out as pads. A later viser may lack the classes that the style
names. Then the buttons stand one below the other with their whole texts, and work as before.
"""

from __future__ import annotations

from collections.abc import Sequence

import viser

from scenarios.viewer.session_state import State

LEFT_RGB, RIGHT_RGB = (0, 131, 148), (214, 106, 0)  # the arms' colours, dark enough under white

_SHEET = """
<style>
.calot { padding: 0 0.75em 0.5em; font-size: 0.82em; line-height: 1.35; }
.calot b { font-weight: 600; }
.calot .dim { opacity: 0.6; }
.calot .now { font-size: 1.25em; font-weight: 600; line-height: 1.25; }
.calot .tag { display: inline-block; border-radius: 0.3em; padding: 0 0.45em; color: white;
  font-size: 0.85em; }
.calot table { border-collapse: collapse; width: 100%; }
.calot td { padding: 0 0.35em 0.05em 0; vertical-align: top; }
.calot td.number { text-align: right; white-space: nowrap; opacity: 0.7; }
.calot tr.now { font-weight: 600; font-size: 1em; }
.calot tr.todo { opacity: 0.5; }
.calot .scroll { max-height: 17em; overflow-y: auto; }
.calot .swatch { display: inline-block; width: 0.8em; height: 0.8em; border-radius: 0.2em;
  margin-right: 0.5em; vertical-align: -0.05em; border: 1px solid rgba(128, 128, 128, 0.5); }
.calot kbd { border: 1px solid rgba(128, 128, 128, 0.6); border-radius: 0.25em; padding: 0 0.35em; }
div:has(> div > .pad) { display: grid; grid-template-columns: repeat(3, 1fr); gap: 0.3em;
  padding: 0.2em 0.6em 0.4em; }
div:has(> div > .pad.two) { grid-template-columns: repeat(2, 1fr); }
div:has(> div > .pad) > div:first-child { display: none; }
div:has(> div > .pad) > div:has(> button) { margin: 0 !important; padding: 0 !important; }
div:has(> div > .pad) > form, div:has(> div > .pad) > div:not(:has(> button)) {
  grid-column: 1 / -1; margin: 0 -0.6em; }
div:has(> div > .pad) button { padding: 0 0.2em; }
div:has(> div > .pad.short) button .mantine-Button-label { font-size: 0; }
div:has(> div > .pad.short) button .mantine-Button-label::after { font-size: 0.8125rem; }
CELLS
</style>
"""


class Panel:
    """Part of the page, made by `Panel(gui, ask)` in viser's current container."""

    def update(self, state: State) -> None:
        """Show the session's state; viser sends only the changes. By default nothing changes."""


def add_style(gui: viser.GuiApi, cells: str = "") -> None:
    """Add the style sheet to the page, with a panel's own rules for `cells`."""
    gui.add_html(_SHEET.replace("CELLS", cells))


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
