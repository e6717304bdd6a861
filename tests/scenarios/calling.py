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


class PlannerCallsLater(PlannerCalls):
    """Asks to grab the gallbladder, and after a second and a half for a person."""

    def plan(self, observation) -> Instruction:
        if observation.time_s < 1.5:
            return Instruction(task=TASKS[0], time_s=observation.time_s)
        return super().plan(observation)


class PlannerGrabs:
    """Asks to grab the gallbladder whatever the anatomy."""

    def __init__(self, setup: PolicySetup) -> None:
        del setup

    def reset(self) -> None:
        pass

    def plan(self, observation) -> Instruction:
        return Instruction(task=TASKS[0], time_s=observation.time_s)
