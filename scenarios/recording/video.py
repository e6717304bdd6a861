"""The endoscope's view of an episode as an mp4."""

from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, ClassVar, Self

from scenarios.loop.results import EpisodeResult
from tissue_sim.periods import CONTROL_HZ


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
    _frames: Any = None

    def __enter__(self) -> Self:
        import imageio.v2 as imageio

        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._frames = imageio.get_writer(
            self._partial, fps=CONTROL_HZ, codec="libx264", macro_block_size=2
        )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._frames.close()
        if self._partial.exists():
            self._partial.replace(self.path)

    def on_reset(self, world: Any) -> None:
        """Add a frame of the initial state."""
        self._world = world
        self._frames.append_data(world.endoscope_rgb())

    def on_step(self, step: Any) -> None:
        """Add a frame after one control step."""
        picture = self._world.endoscope_rgb()
        if self.overlay:
            from scenarios.recording.overlay import overlaid

            picture = overlaid(picture, step.observation)
        self._frames.append_data(picture)

    def on_end(self, result: EpisodeResult) -> None:
        """Do nothing."""

    @property
    def _partial(self) -> Path:
        return self.path.with_suffix(f".partial{self.path.suffix}")
