"""Define SRT-H's ablation "task instructions only": a planner without its corrections."""

from __future__ import annotations

from dataclasses import replace

from planner.base import Planner, hears_of_success
from planner.instruction import Instruction
from planner.policy_setup import is_privileged
from planner.rules.rule_use import RuleUse, rule_uses_of
from tissue_sim.sensing.observation import Observation


class PlannerWithoutCorrections:
    """Repeats another planner's tasks and drops its corrections."""

    def __init__(self, planner: Planner[Observation]) -> None:
        self._planner = planner

    @property
    def privileged(self) -> bool:
        """Return whether the other planner is privileged."""
        return is_privileged(self._planner)

    @property
    def hears_of_success(self) -> bool:
        """Return whether the other planner hears of success."""
        return hears_of_success(self._planner)

    def rule_uses(self) -> tuple[RuleUse, ...]:
        """Return the use of the other planner's rules."""
        return rule_uses_of(self._planner)

    def reset(self) -> None:
        """Forget the episode so far."""
        self._planner.reset()

    def plan(self, observation: Observation) -> Instruction:
        """Return the other planner's instruction without its correction."""
        return replace(self._planner.plan(observation), correction=None)
