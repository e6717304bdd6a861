"""A page with one recording, or two side by side, and a time line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import redirect_stdout
from html import escape
from io import StringIO
from threading import Event, Thread
from time import monotonic
from types import TracebackType
from typing import Self

import viser

from scenarios.viewer.panels.look import theme
from scenarios.viewer.panels.style import add_style, pad
from scenarios.viewer.recording_frames import RecordingFrames, TimelineMark
from scenarios.viewer.scene import SHOWN_FIRST, Scene, look_through
from tissue_sim.patient.axes import field_point

FRAME_S = 1.0 / 20.0
APART_M = 0.30  # of two fields side by side, which are 0.28 wide
TICK_S = 0.1  # of the time line
SPEEDS = {"½ ×": 0.5, "1 ×": 1.0, "2 ×": 2.0, "4 ×": 4.0, "8 ×": 8.0}
LABEL_M = field_point(0.0, -0.036, 0.0)  # below what is operated on


class ReplayPage:
    """Serves while its `with` block lasts; what the reels hold already can be seen."""

    def __init__(
        self, reels: Sequence[RecordingFrames], names: Sequence[str], *, host: str, port: int
    ):
        with redirect_stdout(StringIO()):  # viser's own greeting
            self.server = viser.ViserServer(host=host, port=port, label="Calot", verbose=False)
        self._reels, self._names = tuple(reels), tuple(names)
        self._scenes = stage(self.server, reels)
        for k, name in enumerate(names):
            self.server.scene.add_label(f"/field {k + 1}/name", name, position=LABEL_M)
        self._end_s = max(reel.end_s for reel in reels)
        self._marks = _told(self._reels)
        self._time_s, self._playing = 0.0, True
        self._stop = Event()
        self._make_panel()
        self._drawing = Thread(target=self._draw, name="calot-replay", daemon=True)

    def __enter__(self) -> Self:
        self._drawing.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stop.set()
        self._drawing.join()
        with redirect_stdout(StringIO()):
            self.server.stop()

    @property
    def port(self) -> int:
        """Where it is served."""
        return self.server.get_port()

    def _make_panel(self) -> None:
        gui = self.server.gui
        add_style(gui)
        self._now = gui.add_html("")
        with gui.add_folder("Time line"):
            pad(gui, "two")
            most_s = TICK_S * max(math.ceil(self._end_s / TICK_S), 1)
            self._line = gui.add_slider("s", 0.0, round(most_s, 1), TICK_S, 0.0)
            self._play = gui.add_button("Play or pause", icon=viser.Icon.PLAYER_PLAY)
            self._speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value="1 ×")
        with gui.add_folder("Jump to"):
            pad(gui, "two")
            before = gui.add_button("Before", icon=viser.Icon.PLAYER_SKIP_BACK)
            after = gui.add_button("Next", icon=viser.Icon.PLAYER_SKIP_FORWARD)
            self._jump = gui.add_dropdown("moment", tuple(self._marks))
        gui.main_panel.dock_right()
        space = gui.add_command("play or pause", hotkey="space")
        space.on_trigger(self._on_play)
        self._play.on_click(self._on_play)
        self._line.on_update(self._on_line)
        self._jump.on_update(self._on_jump)
        before.on_click(self._on_before)
        after.on_click(self._on_after)

    async def _on_play(self, _: object) -> None:
        self._playing = not self._playing
        if self._playing and self._time_s >= self._end_s:
            self._time_s = 0.0

    async def _on_line(self, event: viser.GuiEvent) -> None:
        if event.client is not None:  # and not the player itself
            self._go(self._line.value)

    async def _on_jump(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self._go(self._marks[self._jump.value].time_s)

    async def _on_before(self, _: object) -> None:
        earlier = [m.time_s for m in self._marks.values() if m.time_s < self._time_s - TICK_S]
        self._go(max(earlier, default=0.0))

    async def _on_after(self, _: object) -> None:
        later = [m.time_s for m in self._marks.values() if m.time_s > self._time_s + TICK_S]
        self._go(min(later, default=self._end_s))

    def _go(self, time_s: float) -> None:
        self._time_s, self._playing = time_s, False

    def _draw(self) -> None:
        last_s = monotonic()
        while not self._stop.wait(FRAME_S):
            now_s = monotonic()
            if self._playing:
                ahead_s = SPEEDS[self._speed.value] * (now_s - last_s)
                self._time_s = min(self._time_s + ahead_s, self._end_s, self._filled_s())
            last_s = now_s
            if self.server.get_clients():
                self._show(self._time_s)

    def _filled_s(self) -> float:
        """How far the reels have come, the one that is not full and is farthest behind."""
        growing = [r.frames[-1].time_s for r in self._reels if r.frames[-1].time_s < r.end_s]
        return min(growing, default=self._end_s)

    def _show(self, time_s: float) -> None:
        with self.server.atomic():
            for scene, reel in zip(self._scenes, self._reels, strict=True):
                scene.draw(reel.at(time_s))
        self._line.value = round(min(time_s, self._end_s), 1)
        rows = "".join(
            _row(name, reel, time_s) for name, reel in zip(self._names, self._reels, strict=True)
        )
        self._now.content = f'<div class="calot"><div class="now">{time_s:.1f} s</div>{rows}</div>'


def stage(server: viser.ViserServer, reels: Sequence[RecordingFrames]) -> list[Scene]:
    """A scene for each reel, side by side, and a view of the first as its endoscope had it."""
    theme(server.gui, dark=True)
    scenes = []
    for k, reel in enumerate(reels):
        scene = Scene(server.scene, f"/field {k + 1}", (k * APART_M, 0.0, 0.0))
        alone = len(reels) == 1
        scene.shown = SHOWN_FIRST if alone else SHOWN_FIRST - {"abdominal wall"}
        scene.enter(reel.patient)
        scene.draw(reel.frames[0])
        scenes.append(scene)
    T_world_eye = reels[0].frames[0].T_world_endoscope.copy()
    if len(reels) > 1:
        T_world_eye[0, 3] += 0.5 * APART_M * (len(reels) - 1)
        T_world_eye[:3, 3] -= APART_M * T_world_eye[:3, 2]
    look_through(server.initial_camera, T_world_eye)
    return scenes


def _told(reels: Sequence[RecordingFrames]) -> dict[str, TimelineMark]:
    """Marks by what stands in the list: time, text, and whose it is where there are several."""
    told = {}
    for k, reel in enumerate(reels, start=1):
        whose = f"[{k}] " if len(reels) > 1 else ""
        told |= {f"{mark.time_s:6.1f} s  {whose}{mark.text}": mark for mark in reel.marks}
    start = TimelineMark(time_s=0.0, text="start")
    return {start.text: start} | dict(sorted(told.items(), key=lambda item: item[1].time_s))


def _row(name: str, reel: RecordingFrames, time_s: float) -> str:
    """Whose it is, what is said, and whether what is seen is what was."""
    same = "as recorded, to the bit"
    if reel.differs_s is not None:
        same = f"not as recorded from {reel.differs_s:.1f} s on"
    said = escape(reel.instruction(time_s))
    return f'<div><b>{escape(name)}</b> {said}<br><span class="dim">{same}</span></div>'
