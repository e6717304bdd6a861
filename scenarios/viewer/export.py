"""Export a recording as one HTML page that needs no server."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO

import viser

from scenarios.viewer.recording_frames import RecordingFrames
from scenarios.viewer.replay_page import LABEL_M, stage
from tissue_sim.periods import CONTROL_PERIOD_S

EVERY = 6  # control steps a frame: 5 frames a second


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
            serializer.insert_sleep(EVERY * CONTROL_PERIOD_S)
            tell(frame.time_s)
        return serializer.as_html(dark_mode=True)
    finally:
        with redirect_stdout(StringIO()):
            server.stop()
