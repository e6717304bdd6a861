"""Define the planners of SRT-H's ablations: without hierarchy, and without corrections.

Without hierarchy ("no hierarchy"), a policy gets no words as input. `PlannerByRule` has tools
exchanged for such a policy, and gives the rules on the policy's chunks the task that is due. It
decides by observed progress, without learning; it neither gives corrections nor calls a person.
Without corrections ("task instructions only"), another planner's tasks remain.
"""

from __future__ import annotations

from dataclasses import replace

from planner.base import Planner, hears_of_success
from planner.instruction import Instruction
from planner.policy_setup import PolicySetup, is_privileged
from planner.procedure.cholecystectomy import GRAB
from planner.procedure.task import Task
from planner.rules.rule_use import RuleUse, rule_uses_of
from planner.rules.task_gate import TaskClock, gate_task
from tissue_sim.sensing.observation import Observation


class PlannerByRule:
    """Gives the first task that is not observed as done (`planner.rules.task_gate`)."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the episode so far."""
        self._task: Task | None = None
        self._clock = TaskClock()

    def plan(self, observation: Observation) -> Instruction:
        """Return the task that is due now."""
        self._clock.update(observation)
        task = gate_task(self._task or GRAB, self._task, observation, self._clock)
        if task != self._task:
            self._task = task
            self._clock.begin()
        return Instruction(task=task, time_s=observation.time_s)


def make(setup: PolicySetup) -> PlannerByRule:
    """Return the planner, which does not use its setup."""
    del setup
    return PlannerByRule()


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
