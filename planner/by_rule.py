"""Define a planner without learning: observed progress decides which task is next.

In SRT-H's ablation "no hierarchy", a policy gets no words as input. This planner has tools
exchanged for such a policy, and gives the rules on the policy's chunks the task that is due. The
planner neither gives corrections nor calls a person.
"""

from __future__ import annotations

from planner.instruction import Instruction
from planner.policy_setup import PolicySetup
from planner.rules.task_clock import TaskClock
from planner.rules.task_gate import gate_task
from planner.task import GRAB, Task
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
