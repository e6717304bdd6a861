"""SRT-H's ablation "task instructions only": a planner whose corrections nobody hears."""

from __future__ import annotations

from dataclasses import replace

from planner.base import Planner
from planner.instruction import Instruction
from tissue_sim.sensing.observation import Observation


class PlannerWithoutCorrections:
    """Says the task that another planner says, and keeps its corrections back."""

    def __init__(self, planner: Planner[Observation]) -> None:
        self._planner = planner

    @property
    def hears_of_success(self) -> bool:
        """As the other."""
        return self._planner.hears_of_success

    def reset(self) -> None:
        """Forgets the episode so far."""
        self._planner.reset()

    def plan(self, observation: Observation) -> Instruction:
        """What the other says, without a correction."""
        return replace(self._planner.plan(observation), correction=None)
