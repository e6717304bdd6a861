"""SRT-H's ablation "task instructions only": a planner without its corrections."""

from __future__ import annotations

from dataclasses import replace

from planner.base import Planner
from planner.instruction import Instruction
from tissue_sim.sensing.observation import Observation


class PlannerWithoutCorrections:
    """Repeats another planner's tasks and drops its corrections."""

    def __init__(self, planner: Planner[Observation]) -> None:
        self._planner = planner

    @property
    def hears_of_success(self) -> bool:
        """Return the other planner's value."""
        return self._planner.hears_of_success

    def reset(self) -> None:
        """Forget the episode so far."""
        self._planner.reset()

    def plan(self, observation: Observation) -> Instruction:
        """Return the other planner's instruction without its correction."""
        return replace(self._planner.plan(observation), correction=None)
