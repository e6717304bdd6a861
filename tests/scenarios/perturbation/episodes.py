"""Short episodes with perturbations that a test defines."""

from dataclasses import replace
from itertools import islice

import numpy as np

from scenarios.catalogue import SCENARIOS, Scenario
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.perturbations import PERTURBATIONS
from scenarios.run_episode import begin

SEED = 10_001
BY_NAME = {p.name: p for p in PERTURBATIONS}


def disturbed(monkeypatch, *perturbations, seed=SEED, controller="expert"):
    """Return an episode that has not begun, with these perturbations in this order."""
    scenario = Scenario(
        name="of the test", description="", perturbations=perturbations, variant="textbook"
    )
    monkeypatch.setitem(SCENARIOS, scenario.name, scenario)
    return begin(
        EpisodeConfig(planner="scripted", scenario=scenario.name, seed=seed, controller=controller)
    )


def perturbation(name, **changes):
    return replace(BY_NAME[name], **changes)


def trace(episode, steps):
    """Return commands, observations and tissue positions as an array (steps, n)."""
    return np.stack(
        [
            np.concatenate(
                [
                    step.command.joints.ravel(),
                    step.observation.vector(),
                    episode.world.tissue.positions()[::50].ravel(),
                ]
            )
            for step in islice(episode.steps(), steps)
        ]
    )
