"""From the name of a sense to the sense."""

from __future__ import annotations

from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.effects import Effects
from tissue_sim.sensing.exact import SenseExact
from tissue_sim.sensing.sense import Sense
from tissue_sim.sensing.sensor_model import SensorModel
from tissue_sim.sensing.tracked import SenseTracked


def make_sense(config: EpisodeConfig, effects: Effects) -> Sense:
    """Return the sense that a configuration names, for one episode."""
    if config.sense == "exact":
        return SenseExact()
    return SenseTracked(config.seed, effects.on_senses(SensorModel()))
