"""One control step and its outcome, as the loop hands them to observers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from controller.action import Chunk, ToolAction
from controller.safety.ledger import Entry
from planner.instruction import Instruction
from scenarios.loop.person.guided_arm import GuidedArm
from scenarios.loop.person.inbox import Heard
from scenarios.perturbation.effect import Applied
from tissue_sim.sensing.observation import Observation
from tissue_sim.surgery.injury import Injury
from tissue_sim.tools.arms import JointCommand


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a step did to the patient, and whether the running task's criterion is met."""

    events: tuple[Injury, ...]
    task_done: bool


@dataclass(frozen=True, kw_only=True)
class Step:
    """One control step, as observers see it.

    Attributes:
        before: What everybody who acts was told before the command.
        observation: The same, after the command.
        exact: The exact state after the command, for those who record and judge.
        asked: What the controller asked for; None while a perturbation or the nurse has the arms.
        disturbed: Something else than what was asked for reached the driver.
        exchange: The scrub nurse exchanges or reloads the right tool; the policies pause.
        held: A person lets the arms hold: it is no time of the task.
        stays: An arm stays where a person put it, whatever the controller asks for.
        applied: The perturbations that set in with this step.
        altered: What the safety filter noted about this step's command.
        heard: What people said before it, and what came of that.
        told: What the robot says by itself: how orders ended.
        guided: the arm that a person led, and its goal.
        ahead: What is left of the controller's chunk.
        spent_s: Time on the clock by stage, since the step before.
    """

    time_s: float
    instruction: Instruction
    command: JointCommand
    before: Observation
    observation: Observation
    exact: Observation
    outcome: Outcome
    asked: ToolAction | None
    disturbed: bool
    exchange: bool
    applied: tuple[Applied, ...]
    altered: tuple[Entry, ...]
    held: bool = False
    stays: bool = False
    heard: tuple[Heard, ...] = ()
    told: tuple[str, ...] = ()
    guided: GuidedArm | None = None
    ahead: Chunk = ()
    spent_s: Mapping[str, float] = field(default_factory=dict)
