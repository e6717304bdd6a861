"""The endoscope's view of an episode as an mp4."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

from scenarios.loop.results import EpisodeResult
from tissue_sim.saving.video import Video


@dataclass(kw_only=True)
class VideoWriter:
    """Observes an episode in a `with` block; the file is complete when the block is left.

    Asks the world for `endoscope_rgb()`, an image (H, W, 3) of uint8, once a control step.

    Attributes:
        path: of the file.
        overlay: whether what the robot sees is drawn on it.
    """

    needs_images: ClassVar[bool] = True
    path: Path
    overlay: bool = False
    _world: Any = None

    def __post_init__(self) -> None:
        self._video = Video(self.path)

    def __enter__(self) -> Self:
        self._video.__enter__()
        return self

    def __exit__(self, *left: object) -> None:
        self._video.__exit__(*left)

    def on_reset(self, world: Any) -> None:
        """Add a frame of the initial state."""
        self._world = world
        self._video.add(world.endoscope_rgb())

    def on_step(self, step: Any) -> None:
        """Add a frame after one control step."""
        picture = self._world.endoscope_rgb()
        if self.overlay:
            from scenarios.recording.overlay import overlaid

            picture = overlaid(picture, step.observation)
        self._video.add(picture)

    def on_end(self, result: EpisodeResult) -> None:
        """Do nothing."""
