"""A planner that gives one instruction at all times, for a person to override."""

from dataclasses import dataclass

from planner.instruction import TASKS, Instruction
from planner.person.override import PlannerOverridden
from tests.planner.observations import clipped


@dataclass(frozen=True, kw_only=True)
class PlannerFixed:
    """Gives this instruction, whatever it sees."""

    instruction: Instruction
    hears_of_success: bool = False

    def reset(self):
        pass

    def plan(self, observation):
        return self.instruction


def fixed(task=TASKS[0]):
    """Return a planner that a person can override, and that has given this task."""
    planner = PlannerOverridden(PlannerFixed(instruction=Instruction(task=task)))
    planner.plan(clipped())
    return planner
