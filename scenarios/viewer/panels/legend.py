"""Panel with the meaning of the colours and of the keys."""

from __future__ import annotations

from html import escape

import viser

from scenarios.viewer.layers import forces, keep_outs, plan
from scenarios.viewer.layers.layer import Rgb, srgb
from scenarios.viewer.panels.keys import KEYS
from scenarios.viewer.session_state import Asks, State
from tissue_sim.rendering.clip_shape import LOOK as CLIP
from tissue_sim.rendering.drawn.drawn_tissue import looks


class LegendPanel:
    """Colours, which depend on the patient, and keyboard shortcuts."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        del ask
        self._colours = gui.add_html("")
        rows = "".join(
            f"<tr><td><kbd>{escape(key.shown)}</kbd></td><td>{escape(key.label)}</td></tr>"
            for key in KEYS
        )
        gui.add_html(f'<div class="calot"><table>{rows}</table></div>')

    def update(self, state: State) -> None:
        """Show the current patient's colours."""
        anatomy = state.anatomy
        if anatomy is None:
            return
        parts = looks(anatomy, 0.0)
        colours: dict[str, Rgb] = {
            "gallbladder": srgb(parts["gallbladder"].colour),
            "cystic duct": srgb(parts["duct"].colour),
            "cystic artery": srgb(parts["artery"].colour),
            "liver": srgb(anatomy.liver_colour),
            "clip": srgb(CLIP.colour),
            "force of the tissue": forces.COLOUR,
            "left arm's next motions": plan.COLOURS[0],
            "right arm's next motions": plan.COLOURS[1],
            "keep-outs": keep_outs.COLOUR,
        }
        entries = "".join(_entry(name, colour) for name, colour in colours.items())
        self._colours.content = f'<div class="calot">{entries}</div>'


def _entry(name: str, colour: Rgb) -> str:
    return f'<div><span class="swatch" style="background: rgb{colour}"></span>{escape(name)}</div>'
