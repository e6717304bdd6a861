"""A recording as one page that needs no server: to send to somebody."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO

import viser

from scenarios.viewer.recording_frames import RecordingFrames
from scenarios.viewer.replay_page import LABEL_M, stage
from tissue_sim.periods import CONTROL_PERIOD_S

EVERY = 6  # steps a frame: 5 a second


def export(reel: RecordingFrames, tell: Callable[[float], None]) -> str:
    """The page's HTML, all of it; `tell` hears the simulated time it has come to."""
    with redirect_stdout(StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        (scene,) = stage(server, [reel])
        label = server.scene.add_label("/label", "", position=LABEL_M)
        serializer = server.get_scene_serializer()
        for frame in reel.run():
            label.text = f"{frame.time_s:.1f} s  {reel.instruction(frame.time_s)}"
            scene.draw(frame)
            serializer.insert_sleep(EVERY * CONTROL_PERIOD_S)
            tell(frame.time_s)
        return serializer.as_html(dark_mode=True)
    finally:
        with redirect_stdout(StringIO()):
            server.stop()
