"""Write the endoscope's view of an episode as an mp4."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from scenarios.loop.results import EpisodeResult
from tissue_sim.constants import CONTROL_HZ
from tissue_sim.rendering.video import Video

if TYPE_CHECKING:  # heavy to import
    from scenarios.recording.event_log import EventLog

CLOSING_S = 3.0  # duration of the result at the end


@dataclass(kw_only=True)
class VideoWriter:
    """Observes an episode in a `with` block; the file is complete when the block is left.

    The writer calls the world's `endoscope_rgb()` once a control step, for an image (H, W, 3) of
    uint8.

    Attributes:
        path: Path of the file.
        overlay: Whether the robot's observation is drawn on the picture.
        captions: Whether a band below the picture shows the instructions, their reasons, and at
            last the result.
    """

    needs_images: ClassVar[bool] = True
    path: Path
    overlay: bool = False
    captions: bool = False
    _world: Any = None
    _log: EventLog | None = None

    def __post_init__(self) -> None:
        self._video = Video(self.path)

    def __enter__(self) -> Self:
        self._video.__enter__()
        return self

    def __exit__(self, *left: object) -> None:
        self._video.__exit__(*left)

    def on_reset(self, world: Any) -> None:
        """Add a frame of the initial state."""
        if self.captions:
            from scenarios.recording.event_log import EventLog

            self._log = EventLog()
        self._world, self._picture = world, world.endoscope_rgb()
        self._add()

    def on_step(self, step: Any) -> None:
        """Add a frame after one control step."""
        self._picture = self._world.endoscope_rgb()
        if self.overlay:
            from scenarios.recording.overlay import overlaid

            self._picture = overlaid(self._picture, step.observation)
        if self._log is not None:
            self._log.note(step)
        self._add()

    def on_end(self, result: EpisodeResult) -> None:
        """Add the result for some seconds, if there are captions."""
        if self._log is not None:
            self._log.end(result)
            for _ in range(round(CLOSING_S * CONTROL_HZ)):
                self._add()

    def _add(self) -> None:
        picture = self._picture
        if self._log is not None:
            from scenarios.recording.captions import captioned

            picture = captioned(picture, self._log.status)
        self._video.add(picture)
