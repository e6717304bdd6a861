"""Tests of a planner whose corrections are withheld: it gives its tasks and nothing more."""

from dataclasses import dataclass, replace
from itertools import islice

from planner.ablations import PlannerWithoutCorrections
from planner.instruction import CORRECTIONS
from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin


@dataclass
class Correcting:
    """Adds a correction to each instruction of another planner."""

    planner: object

    @property
    def hears_of_success(self):
        return self.planner.hears_of_success

    def reset(self):
        self.planner.reset()

    def plan(self, observation):
        return replace(self.planner.plan(observation), correction=CORRECTIONS[0])


def test_tasks_pass_and_corrections_are_dropped():
    episode = begin(
        EpisodeConfig(**ORACLE, scenario="textbook", seed=10_004, ablation="no-corrections")
    )
    assert isinstance(episode.planner, PlannerWithoutCorrections)
    planner = PlannerWithoutCorrections(Correcting(episode.planner._planner))
    episode = replace(episode, planner=planner)
    said = {step.instruction.text for step in islice(episode.steps(), 45)}
    assert said == {"grabbing gallbladder"}
