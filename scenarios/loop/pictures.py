"""Pictures for a controller from pixels: drawn on request, of the size in datasets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from controller.dataset.schema import PICTURE_SHAPE
from tissue_sim.rendering.shader_pack import COLOR_PICTURE
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.pictures.cameras import CameraSpec
from tissue_sim.world import World

HEIGHT, WIDTH, _ = PICTURE_SHAPE


def specs_of(cameras: Sequence[str]) -> list[CameraSpec]:
    """Return the cameras of these names, with pictures of the size in datasets."""
    return [CameraSpec(name=name, width=WIDTH, height=HEIGHT) for name in cameras]


class Pictures:
    """Draws the pictures of some cameras; without cameras it does nothing."""

    def __init__(self, cameras: Sequence[str]) -> None:
        self._specs = specs_of(cameras)

    def added_to(self, seen: Observation, world: World) -> Observation:
        """Return an observation with the cameras' pictures now, (240, 320, 3) uint8 each.

        Raises:
            ValueError: The world was made without `render`.
        """
        if not self._specs:
            return seen
        if world.view is None:
            raise ValueError("pictures: the world has no cameras: make it with render=True")
        drawn = world.view.pictures(world, self._specs)[COLOR_PICTURE]
        return replace(seen, images=seen.images | drawn)
