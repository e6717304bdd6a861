"""Keyboard shortcuts, and the panel that explains them and the colours.

Ctrl+K shows the shortcuts on the page, too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import viser

from scenarios.viewer.layers.layer import Rgb, srgb
from scenarios.viewer.layers.overlays import FORCE_COLOUR, KEEP_OUT_COLOUR, PLAN_COLOURS
from scenarios.viewer.pace import Pace
from scenarios.viewer.panels.panel import Panel, asking, html
from scenarios.viewer.panels.talk import GO_ON, HOLD
from scenarios.viewer.session_state import Asks, SessionState, State
from tissue_sim.rendering.clip_shape import look_of
from tissue_sim.rendering.drawn_tissue import looks
from tissue_sim.tools.clips import CLIPS


@dataclass(frozen=True, kw_only=True)
class Key:
    """A key, and what it asks of the session: a method, and what the method is told."""

    hotkey: str
    label: str
    method: Callable[..., None] = SessionState.press
    told: tuple[Any, ...] = ()
    shift: bool = False

    @property
    def shown(self) -> str:
        """Return the key's name for people to read."""
        return f"Shift+{self.hotkey}" if self.shift else self.hotkey


_MOVES = {  # keys of the right hand, placed like arrow keys
    "I": "move {} arm higher",
    "J": "move {} arm to the left",
    "K": "move {} arm lower",
    "L": "move {} arm to the right",
    "U": "move {} arm away from me",
    "O": "move {} arm towards me",
}
_JAWS = {"Y": "open {} gripper", "P": "close {} gripper"}
KEYS: tuple[Key, ...] = (
    Key(
        hotkey="space",
        label="start or pause",
        method=SessionState.drive,
        told=(Pace.start_or_pause,),
    ),
    Key(hotkey="N", label="one step", method=SessionState.drive, told=(Pace.step,)),
    Key(hotkey="H", label="hold still", told=(HOLD,)),
    Key(hotkey="B", label="back to the planner", told=(GO_ON,)),
    *(
        Key(hotkey=key, label=said, told=(said,), shift=arm == "left")
        for acts in (_MOVES, _JAWS)
        for arm in ("right", "left")
        for key, said in ((key, act.format(arm)) for key, act in acts.items())
    ),
)


def add_keys(gui: viser.GuiApi, ask: Asks) -> None:
    """Add all shortcuts to the page."""
    for key in KEYS:
        handle = gui.add_command(
            key.label,
            hotkey=key.hotkey,  # pyright: ignore[reportArgumentType]
            modifier="shift" if key.shift else None,
        )
        handle.on_trigger(asking(ask, key.method, *key.told))


class LegendPanel(Panel):
    """Colours, which depend on the patient, and keyboard shortcuts."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._colours = gui.add_html("")
        gui.add_html(html("keys", keys=KEYS))

    def update(self, state: State) -> None:
        """Show the current patient's colours."""
        anatomy = state.anatomy
        if anatomy is None:
            return
        parts = looks(anatomy, 0.0)
        artery = "cystic artery" if anatomy.second_artery is None else "cystic arteries"
        colours: dict[str, Rgb] = {
            "gallbladder": srgb(parts["gallbladder"].colour),
            "cystic duct": srgb(parts["duct"].colour),
            artery: srgb(parts["artery"].colour),
            "liver": srgb(anatomy.liver_colour),
            **{f"{name} clip": srgb(look_of(kind).colour) for name, kind in CLIPS.items()},
            "force of the tissue": FORCE_COLOUR,
            "left arm's next motions": PLAN_COLOURS[0],
            "right arm's next motions": PLAN_COLOURS[1],
            "keep-outs": KEEP_OUT_COLOUR,
        }
        self._colours.content = html("colours", colours=colours)
