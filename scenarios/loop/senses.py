"""Make a sense from its name: Calot's own, or an outside one of MODULE:FACTORY."""

from __future__ import annotations

from pkgutil import resolve_name

from scenarios.catalogue import sense_named
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.effects import Effects
from tissue_sim.sensing.sense import Sense, SenseSetup
from tissue_sim.sensing.sensor_model import SensorModel


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
