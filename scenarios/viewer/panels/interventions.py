"""Panels by which a person intervenes: corrections, taking over an arm, saving training data."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterable
from threading import Lock
from typing import Any

import numpy as np
import viser
from viser.transforms import SO3

from planner.correction import CORRECTIONS
from scenarios.files.outside_text import visible
from scenarios.loop.person.guided_arm import GuidedArm
from scenarios.viewer.layers.layer import wxyz
from scenarios.viewer.panels.panel import LEFT_RGB, RIGHT_RGB, Panel, asking, cells, pad
from scenarios.viewer.session_state import Asks, SessionState, State
from tissue_sim.frames import pose
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS

GIZMO_M = 0.02
_SHUT_RAD = -0.2  # presses the jaws together
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
    ("right", "Right arm: clip appliers, scissors", RIGHT_RGB),
)


class CorrectionPanel(Panel):
    """The 18 corrections: a pad of buttons for each arm, and buttons for the jaws of both.

    A pad is laid out by direction in the endoscope's view.
    """

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        for arm, title, colour in _PADS:
            with gui.add_folder(title):
                pad(gui, "arm short")
                _add_corrections(gui, ask, arm, _PLACES, colour)
        with gui.add_folder("Both"):
            pad(gui, "two")
            _add_corrections(gui, ask, "both", ("open", "close"), (90, 90, 100))


def _add_corrections(
    gui: viser.GuiApi, ask: Asks, arm: str, ways: Iterable[str], colour: tuple[int, int, int]
) -> None:
    """Add a button for each direction or jaw motion of an arm."""
    for way in ways:
        said = next(c.text for c in CORRECTIONS if c.arm == arm and way in (c.direction, c.jaw))
        button = gui.add_button(said, color=colour)
        button.on_click(asking(ask, SessionState.press, said))


class TakeOverPanel(Panel):
    """Buttons to take over an arm and give it back, and a slider for its jaws.

    The arm follows a gizmo, through the safety filter.
    """

    def __init__(self, gui: viser.GuiApi, scene: viser.SceneApi, ask: Asks) -> None:
        self._scene, self._ask = scene, ask
        self._gizmo: viser.TransformControlsHandle | None = None
        self._arm = LEFT_ARM
        self._changing = Lock()  # clicks come from another thread than `update`
        with gui.add_folder("Take over an arm", expand_by_default=False):
            pad(gui, "two")
            left = gui.add_button("Take the left", color=LEFT_RGB)
            right = gui.add_button("Take the right", color=RIGHT_RGB)
            self._jaw = gui.add_slider("jaws open", 0.0, 100.0, 1.0, 50.0, visible=False)
            self._back = gui.add_button("Give it back", visible=False, color="green")
        left.on_click(self._alone(lambda: self._take(LEFT_ARM)))
        right.on_click(self._alone(lambda: self._take(RIGHT_ARM)))
        self._jaw.on_update(self._alone(self._guide))
        self._back.on_click(self._alone(self._give_back))

    def _alone(self, act: Callable[[], None]) -> Callable[[object], Coroutine[Any, Any, None]]:
        """Return a callback that acts while nothing else changes the panel."""

        async def call(_: object) -> None:
            with self._changing:
                act()

        return call

    def update(self, state: State) -> None:
        """Give the arm back if the session has ended the guidance, as a new episode does."""
        if state.guided:
            return
        with self._changing:  # the arm may have been taken since `state`
            if self._gizmo is not None and not self._ask(SessionState.state).guided:
                self._give_back()

    def _take(self, arm: int) -> None:
        frame = self._ask(SessionState.frame)
        if frame is None:
            return
        self._give_back()
        self._arm, T = arm, frame.T_world_tool[arm]
        shut, wide = _SHUT_RAD, INSTRUMENTS[frame.tools[arm]].jaw_range_rad[1]
        self._jaw_range_rad = shut, wide
        share = float(np.clip((frame.jaw_rad[arm] - shut) / (wide - shut), 0.0, 1.0))
        self._jaw.value = float(round(100 * share))
        self._gizmo = self._scene.add_transform_controls(
            "/take_over",
            scale=GIZMO_M,
            depth_test=False,
            position=T[:3, 3],
            wxyz=wxyz(T[:3, :3]),
        )
        self._gizmo.on_update(self._alone(self._guide))
        self._jaw.visible = self._back.visible = True
        self._guide()

    def _guide(self) -> None:
        if self._gizmo is None:
            return
        shut, wide = self._jaw_range_rad
        try:
            arm = GuidedArm(
                arm=self._arm,
                T_world_goal=pose(_rotation(self._gizmo.wxyz), np.array(self._gizmo.position)),
                jaw_rad=shut + (wide - shut) * min(max(self._jaw.value / 100.0, 0.0), 1.0),
            )
        except ValueError:
            return  # no pose: the arm keeps its goal
        self._ask(SessionState.guide, arm)

    def _give_back(self) -> None:
        self._ask(SessionState.guide, None)
        if self._gizmo is not None:
            self._gizmo.remove()
            self._gizmo = None
        self._jaw.visible = self._back.visible = False


class TrainingDataPanel(Panel):
    """A button to save an intervention; a notification shows the path or the error."""

    def __init__(self, gui: viser.GuiApi, ask: Asks) -> None:
        self._ask = ask
        self._save = gui.add_button(
            "Save this intervention as training data",
            icon=viser.Icon.DATABASE_PLUS,
            color="indigo",
            disabled=True,
        )
        self._save.on_click(self._on_save)

    def _on_save(self, event: viser.GuiEvent) -> None:
        """Save; viser calls this in a separate thread, so it may take time."""
        try:
            title, body, colour = "Saved", str(self._ask(SessionState.save_intervention)), "green"
        except (OSError, ValueError) as error:
            title, body, colour = "Not saved", str(error), "red"
        if event.client is not None:
            event.client.add_notification(
                title, visible(body), color=colour, auto_close_seconds=8.0
            )

    def update(self, state: State) -> None:
        """Enable the button once there is an intervention."""
        self._save.disabled = not state.intervened


def _rotation(wxyz: np.ndarray) -> np.ndarray:
    """Return the (3, 3) rotation matrix of a quaternion of any length.

    Raises:
        ValueError: The quaternion is zero or not finite.
    """
    length = float(np.linalg.norm(wxyz))
    if not 0.0 < length < np.inf:
        raise ValueError(f"{wxyz!r} is no rotation")
    return SO3(np.asarray(wxyz, float) / length).as_matrix()
