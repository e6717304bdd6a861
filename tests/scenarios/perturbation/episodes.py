"""Short episodes under perturbations of a test's own."""

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
    """An episode that has not begun, under perturbations in their order."""
    scenario = Scenario(name="of the test", description="", perturbations=perturbations)
    monkeypatch.setitem(SCENARIOS, scenario.name, scenario)
    return begin(
        EpisodeConfig(planner="scripted", scenario=scenario.name, seed=seed, controller=controller)
    )


def perturbation(name, **changes):
    return replace(BY_NAME[name], **changes)


def trace(episode, steps):
    """What was commanded and seen, and where the tissue went: (steps, n)."""
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
