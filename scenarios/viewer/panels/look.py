"""Panel with the choice of layers, the view, and a dark or light page."""

from __future__ import annotations

import viser

from scenarios.viewer.panels.panel import Panel
from scenarios.viewer.scene import OPTIONAL, ViewerScene, look_through
from scenarios.viewer.session_state import Asks, SessionState


class LookPanel(Panel):
    """Check boxes for layers, for all tabs; dark or light, for each tab."""

    def __init__(self, gui: viser.GuiApi, scene: ViewerScene, ask: Asks) -> None:
        self._ask, self._scene = ask, scene
        with gui.add_folder("View", expand_by_default=False):
            view = gui.add_button("Look through the endoscope", icon=viser.Icon.EYE, color="gray")
            self._shown = {name: gui.add_checkbox(name, name in scene.shown) for name in OPTIONAL}
            self._light = gui.add_checkbox("light page", False)
        view.on_click(self._on_view)
        self._light.on_update(self._on_light)
        for checkbox in self._shown.values():
            checkbox.on_update(self._on_shown)

    async def _on_view(self, event: viser.GuiEvent) -> None:
        frame = self._ask(SessionState.frame)
        if event.client is not None and frame is not None:
            with event.client.atomic():
                look_through(event.client.camera, frame.T_world_endoscope)

    async def _on_light(self, event: viser.GuiEvent) -> None:
        theme(event.client.gui if event.client else None, dark=not self._light.value)

    async def _on_shown(self, _: object) -> None:
        self._scene.shown = frozenset(name for name, box in self._shown.items() if box.value)


def theme(gui: viser.GuiApi | None, *, dark: bool) -> None:
    """Make the page dark or light, without viser's logo and share button."""
    if gui is not None:
        gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False)
