"""Steps of an episode with random numbers in them, for what observes one."""

from dataclasses import replace

from planner.instruction import TASKS, Instruction
from scenarios.loop.step import Outcome, Step
from tests.planner.observations import clipped
from tissue_sim.tools.arms import JointCommand


def random_step(rng, number, instruction=None, events=(), **kept):
    seen = replace(
        clipped(time_s=number / 30),
        joints=rng.normal(size=(2, 7)),
        tips_endoscope=rng.normal(size=(2, 4, 4)),
        forces_n=rng.normal(size=(2, 3)),
    )
    given = {
        "instruction": instruction or Instruction(task=TASKS[0]),
        "command": JointCommand(joints=rng.normal(size=(2, 7))),
        "outcome": Outcome(events=events, task_done=False),
        "applied": (),
        "altered": (),
    }
    return Step(
        time_s=seen.time_s,
        before=seen,
        observation=seen,
        exact=seen,
        asked=None,
        disturbed=False,
        exchange=False,
        **given | kept,
    )
