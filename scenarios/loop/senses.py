"""What policies perceive: a sense by its name, and pictures for a controller from pixels.

A sense is Calot's own, or an outside one of MODULE:FACTORY. Pictures are drawn on request, of the
size in datasets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pkgutil import resolve_name
from typing import TYPE_CHECKING

from controller.dataset.schema import PICTURE_SHAPE
from scenarios.catalogue import sense_named
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.effects import Effects
from tissue_sim.rendering.shader_pack import COLOR_PICTURE
from tissue_sim.sensing.cameras import CameraSpec
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.sense import Sense
from tissue_sim.sensing.sensor_model import SenseSetup, SensorModel

if TYPE_CHECKING:
    from tissue_sim.world import World

HEIGHT, WIDTH, _ = PICTURE_SHAPE


def make_sense(config: EpisodeConfig, effects: Effects) -> Sense:
    """Return the sense that a configuration names, for one episode.

    Raises:
        CheckpointError: The file holds no perception, or the perception does not fit.
        ValueError: There is no such factory, or its product is no sense.
    """
    setup = SenseSetup(
        seed=config.seed,
        checkpoint=config.perception_checkpoint,
        model=effects.on_senses(SensorModel()),
        spoil=effects.on_picture,
    )
    sense = resolve_name(sense_named(config.sense).factory)(setup)
    if not callable(getattr(sense, "observe", None)):
        raise ValueError(f"{config.sense}: the {type(sense).__name__} it makes has no observe")
    return sense


def specs_of(cameras: Sequence[str]) -> list[CameraSpec]:
    """Return the cameras of these names, with pictures of the size in datasets."""
    return [CameraSpec(name=name, width=WIDTH, height=HEIGHT) for name in cameras]


class Pictures:
    """Draws the pictures of some cameras; without cameras it does nothing."""

    def __init__(self, cameras: Sequence[str]) -> None:
        self._specs = specs_of(cameras)

    def added_to(self, observation: Observation, world: World) -> Observation:
        """Return an observation with the cameras' pictures now, (240, 320, 3) uint8 each.

        Raises:
            ValueError: The world was made without `render`.
        """
        if not self._specs:
            return observation
        if world.view is None:
            raise ValueError("pictures: the world has no cameras: make it with render=True")
        drawn = world.view.pictures(world, self._specs)[COLOR_PICTURE]
        return replace(observation, images=observation.images | drawn)
