"""Outside planners that ask for a person, or never do."""

from planner.instruction import TASKS, Instruction
from planner.policy_setup import PolicySetup

UNSURE = "I am not sure which tube is which."


class PlannerCalls:
    """Calls for a person at once."""

    def __init__(self, setup: PolicySetup) -> None:
        del setup

    def reset(self) -> None:
        pass

    def plan(self, observation) -> Instruction:
        return Instruction(
            task=TASKS[0], hold=True, call=True, remark=UNSURE, time_s=observation.time_s
        )


class PlannerGrabs:
    """Asks to grab the gallbladder whatever the anatomy."""

    def __init__(self, setup: PolicySetup) -> None:
        del setup

    def reset(self) -> None:
        pass

    def plan(self, observation) -> Instruction:
        return Instruction(task=TASKS[0], time_s=observation.time_s)
