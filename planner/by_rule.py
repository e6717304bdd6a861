"""A planner without learning: what is seen to be done decides what is next.

In SRT-H's ablation "no hierarchy" it does what must be done for a policy that hears no words: it
has tools exchanged, and tells the rules of a policy's chunks which task is due. It corrects
nothing, and calls nobody.
"""

from __future__ import annotations

from planner.instruction import Instruction
from planner.policy_setup import PolicySetup
from planner.seen.done import has_slipped
from planner.seen.due import due
from planner.seen.task_clock import TaskClock
from planner.task import GRAB, Task
from tissue_sim.sensing.observation import Observation


class PlannerByRule:
    """Gives the first task that is not seen to be done (`planner.seen.due`).

    A gallbladder that has slipped before the first cut is grabbed again.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the episode so far."""
        self._task: Task | None = None
        self._clock = TaskClock()

    def plan(self, observation: Observation) -> Instruction:
        """Return the task that is due now."""
        self._clock.see(observation)
        given, clock = self._task, self._clock
        asked = GRAB if given is None or has_slipped(observation) else given
        task = due(asked, given, clock.since_s, observation, clock.pulled_s, clock.grasped_s)
        if task != given:
            self._task = task
            clock.begin()
        return Instruction(task=task, time_s=observation.time_s)


def make(setup: PolicySetup) -> PlannerByRule:
    """Return the planner; nothing in its setup concerns it."""
    del setup
    return PlannerByRule()
