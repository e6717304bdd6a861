"""A page with one recording, or two side by side: served with a timeline, or exported.

An exported recording is one HTML page that needs no server.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from io import StringIO
from time import monotonic

import viser

from scenarios.viewer.panels.look import theme
from scenarios.viewer.panels.panel import add_style, html, pad
from scenarios.viewer.recording_frames import RecordingFrames, TimelineMark
from scenarios.viewer.scene import SHOWN_FIRST, ViewerScene, look_through
from scenarios.viewer.serving.drawn_page import DrawnPage
from scenarios.viewer.serving.gate import gate_for
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import field_point

APART_M = 0.30  # between fields side by side, which are 0.28 wide
TICK_S = 0.1  # resolution of the timeline
SPEEDS = {"½ ×": 0.5, "1 ×": 1.0, "2 ×": 2.0, "4 ×": 4.0, "8 ×": 8.0}
LABEL_M = field_point(0.0, -0.036, 0.0)  # below the organ
EXPORT_EVERY = 6  # control steps a frame of an exported page: 5 frames a second


class ReplayPage(DrawnPage):
    """A page of recordings. Shows the frames that are ready so far."""

    def __init__(
        self, recordings: Sequence[RecordingFrames], names: Sequence[str], *, host: str, port: int
    ):
        super().__init__(gate_for(host), host=host, port=port)
        self._recordings, self._names = tuple(recordings), tuple(names)
        self._scenes = stage(self.server, recordings)
        for k, name in enumerate(names):
            self.server.scene.add_label(f"/field {k + 1}/name", name, position=LABEL_M)
        self._end_s = max(recording.end_s for recording in recordings)
        self._marks = _labelled(self._recordings)
        self._time_s, self._playing = 0.0, True
        self._drawn_s = monotonic()
        self._make_panel()

    def _make_panel(self) -> None:
        gui = self.server.gui
        add_style(gui)
        self._now = gui.add_html("")
        with gui.add_folder("Timeline"):
            pad(gui, "two")
            most_s = TICK_S * max(math.ceil(self._end_s / TICK_S), 1)
            self._timeline = gui.add_slider("s", 0.0, round(most_s, 1), TICK_S, 0.0)
            self._play = gui.add_button("Play or pause", icon=viser.Icon.PLAYER_PLAY)
            self._speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value="1 ×")
        with gui.add_folder("Jump to"):
            pad(gui, "two")
            before = gui.add_button("Previous", icon=viser.Icon.PLAYER_SKIP_BACK)
            after = gui.add_button("Next", icon=viser.Icon.PLAYER_SKIP_FORWARD)
            self._jump = gui.add_dropdown("mark", tuple(self._marks))
        gui.main_panel.dock_right()
        space = gui.add_command("play or pause", hotkey="space")
        space.on_trigger(self._on_play)
        self._play.on_click(self._on_play)
        self._timeline.on_update(self._on_timeline)
        self._jump.on_update(self._on_jump)
        before.on_click(self._on_before)
        after.on_click(self._on_after)

    async def _on_play(self, _: object) -> None:
        self._playing = not self._playing
        if self._playing and self._time_s >= self._end_s:
            self._time_s = 0.0

    async def _on_timeline(self, event: viser.GuiEvent) -> None:
        if event.client is not None:  # a person moved the slider, not the player
            self._go(self._timeline.value)

    async def _on_jump(self, event: viser.GuiEvent) -> None:
        if event.client is not None and (mark := self._marks.get(self._jump.value)) is not None:
            self._go(mark.time_s)

    async def _on_before(self, _: object) -> None:
        earlier = [m.time_s for m in self._marks.values() if m.time_s < self._time_s - TICK_S]
        self._go(max(earlier, default=0.0))

    async def _on_after(self, _: object) -> None:
        later = [m.time_s for m in self._marks.values() if m.time_s > self._time_s + TICK_S]
        self._go(min(later, default=self._end_s))

    def _go(self, time_s: float) -> None:
        self._time_s, self._playing = min(max(time_s, 0.0), self._end_s), False

    def draw(self) -> None:
        """Show the recordings at the time to which they have been played."""
        now_s = monotonic()
        if self._playing:
            ahead_s = SPEEDS.get(self._speed.value, 1.0) * (now_s - self._drawn_s)
            self._time_s = min(self._time_s + ahead_s, self._end_s, self._filled_s())
        self._drawn_s = now_s
        if self.server.get_clients():
            self._show(self._time_s)

    def _filled_s(self) -> float:
        """Return the time up to which all recordings can be shown."""
        growing = [r.frames[-1].time_s for r in self._recordings if r.frames[-1].time_s < r.end_s]
        return min(growing, default=self._end_s)

    def _show(self, time_s: float) -> None:
        with self.server.atomic():
            for scene, recording in zip(self._scenes, self._recordings, strict=True):
                scene.draw(recording.at(time_s))
        self._timeline.value = round(min(time_s, self._end_s), 1)
        shown = list(zip(self._names, self._recordings, strict=True))
        self._now.content = html("replay", recordings=shown, time_s=time_s)


def export(recording: RecordingFrames, tell: Callable[[float], None]) -> str:
    """Return the page's HTML; `tell` receives the simulated time of each finished frame."""
    with redirect_stdout(StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        (scene,) = stage(server, [recording])
        label = server.scene.add_label("/label", "", position=LABEL_M)
        serializer = server.get_scene_serializer()
        for frame in recording.run():
            label.text = f"{frame.time_s:.1f} s  {recording.instruction(frame.time_s)}"
            scene.draw(frame)
            serializer.insert_sleep(EXPORT_EVERY * CONTROL_PERIOD_S)
            tell(frame.time_s)
        return serializer.as_html(dark_mode=True)
    finally:
        with redirect_stdout(StringIO()):
            server.stop()


def stage(server: viser.ViserServer, recordings: Sequence[RecordingFrames]) -> list[ViewerScene]:
    """Create a scene for each recording, side by side, seen as by the first one's endoscope."""
    theme(server.gui, dark=True)
    scenes = []
    for k, recording in enumerate(recordings):
        scene = ViewerScene(server.scene, f"/field {k + 1}", (k * APART_M, 0.0, 0.0))
        alone = len(recordings) == 1
        scene.shown = SHOWN_FIRST if alone else SHOWN_FIRST - {"abdominal wall"}
        scene.enter(recording.patient)
        scene.draw(recording.frames[0])
        scenes.append(scene)
    T_world_eye = recordings[0].frames[0].T_world_endoscope.copy()
    if len(recordings) > 1:
        T_world_eye[0, 3] += 0.5 * APART_M * (len(recordings) - 1)
        T_world_eye[:3, 3] -= APART_M * T_world_eye[:3, 2]
    look_through(server.initial_camera, T_world_eye)
    return scenes


def _labelled(recordings: Sequence[RecordingFrames]) -> dict[str, TimelineMark]:
    """Return the marks by label: time, number of the recording if there are several, text."""
    labelled = {}
    for k, recording in enumerate(recordings, start=1):
        number = f"[{k}] " if len(recordings) > 1 else ""
        labelled |= {f"{mark.time_s:6.1f} s  {number}{mark.text}": mark for mark in recording.marks}
    start = TimelineMark(time_s=0.0, text="start")
    return {start.text: start} | dict(sorted(labelled.items(), key=lambda item: item[1].time_s))
