"""From the name of a sense to the sense."""

from __future__ import annotations

from scenarios.loop.episode_config import EpisodeConfig
from tissue_sim.sensing.exact import SenseExact
from tissue_sim.sensing.sense import Sense
from tissue_sim.sensing.tracked import SenseTracked


def make_sense(config: EpisodeConfig) -> Sense:
    """Return the sense that a configuration names, for one episode."""
    if config.sense == "exact":
        return SenseExact()
    return SenseTracked(config.seed)
