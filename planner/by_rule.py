"""A planner without learning: what is seen to be done decides what is next.

In SRT-H's ablation "no hierarchy" it does what must be done for a policy that hears no words: it
has tools exchanged, and tells the rules of a policy's chunks which task is due. It corrects
nothing, and calls nobody.
"""

from __future__ import annotations

from planner.instruction import Instruction
from planner.policy_setup import PolicySetup
from planner.rules.task_clock import TaskClock
from planner.rules.task_gate import gate_task
from planner.task import GRAB, Task
from tissue_sim.sensing.observation import Observation


class PlannerByRule:
    """Gives the first task that is not seen to be done (`planner.rules.task_gate`)."""

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
    """Return the planner; nothing in its setup concerns it."""
    del setup
    return PlannerByRule()
