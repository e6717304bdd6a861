"""One control step and its outcome, as the loop passes them to observers."""

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
    """The effects of a step on the patient, and whether the running task's criterion is met."""

    events: tuple[Injury, ...]
    task_done: bool


@dataclass(frozen=True, kw_only=True)
class Step:
    """One control step, as observers receive it.

    Attributes:
        before: The observation of planner, controller and filter before the command.
        observation: The same, after the command.
        exact: The exact state after the command, for observers that record and judge.
        asked: The controller's requested action; None while a perturbation or the nurse has the
            arms.
        disturbed: The driver received another action than the requested one.
        exchange: The scrub nurse exchanges or reloads the right tool; the policies pause.
        held: A person lets the arms hold; the step does not count in the task's time.
        stays: An arm stays where a person put it, whatever the controller requests.
        applied: The perturbations that set in with this step.
        altered: The safety filter's entries about this step's command.
        heard: People's words before the step, and their outcome.
        told: The robot's reports of how orders ended.
        guided: The arm that a person led, and its goal.
        ahead: The rest of the controller's chunk.
        spent_s: Wall time by stage, since the step before.
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
