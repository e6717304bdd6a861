"""From the name of a sense to the sense."""

from __future__ import annotations

from scenarios.catalogue import PERCEIVING
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.effects import Effects
from tissue_sim.sensing.exact import SenseExact
from tissue_sim.sensing.sense import Sense
from tissue_sim.sensing.sensor_model import SensorModel
from tissue_sim.sensing.tracked import SenseTracked


def make_sense(config: EpisodeConfig, effects: Effects) -> Sense:
    """Return the sense that a configuration names, for one episode.

    Raises:
        CheckpointError: there is no perception in its file, or it does not fit.
    """
    if config.sense == "exact":
        return SenseExact()
    if config.sense in PERCEIVING:
        from controller.perception.perception import load_perception
        from scenarios.loop.camera_sense import SenseCameras
        from tissue_sim.sensing.pictures.eyes import ENDOSCOPE_VIEWS, VIEWS

        perception = load_perception(config.perception_checkpoint)
        views = ENDOSCOPE_VIEWS if config.sense == "endoscope" else VIEWS
        return SenseCameras(config.seed, perception, spoil=effects.on_picture, views=views)
    return SenseTracked(config.seed, effects.on_senses(SensorModel()))
