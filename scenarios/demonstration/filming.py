"""Film an episode for a dataset: the cameras' pictures before each of its frames."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Self

from controller.dataset.part import video_path
from scenarios.demonstration.demonstration_recorder import is_frame
from scenarios.loop.observer import Observer
from scenarios.loop.senses import specs_of
from scenarios.loop.step import Step
from tissue_sim.rendering.shader_pack import COLOR_PICTURE
from tissue_sim.rendering.video import Video

if TYPE_CHECKING:
    from tissue_sim.world import World

KEYFRAMES = 2  # from one to the next, as in LeRobot's own videos


class Filming(Observer):
    """Observes one episode in a `with` block; the videos are complete when the block is left."""

    needs_images: ClassVar[bool] = True

    def __init__(self, cameras: Sequence[str], part: Path) -> None:
        """Film by `cameras`, into files beside `part`."""
        self._specs = specs_of(cameras)
        self._videos = {name: Video(video_path(part, name), KEYFRAMES) for name in cameras}
        self._open = ExitStack()

    def __enter__(self) -> Self:
        for video in self._videos.values():
            self._open.enter_context(video)
        return self

    def __exit__(self, *left: object) -> None:
        self._open.close()

    def on_reset(self, world: World) -> None:
        """Take the pictures before the first step."""
        self._world = world
        self._take()

    def on_step(self, step: Step) -> None:
        """Add the pictures from before the step, if it is a frame, and take those after it."""
        if is_frame(step):
            for name, video in self._videos.items():
                video.add(self._shown[name])
        self._take()

    def _take(self) -> None:
        assert self._world.view is not None, "a world that is filmed has cameras"
        self._shown = self._world.view.pictures(self._world, self._specs)[COLOR_PICTURE]
