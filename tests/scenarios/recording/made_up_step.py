"""Made-up steps of an episode, for what observes one."""

from dataclasses import dataclass

import numpy as np

from controller.safety.ledger import Entry
from planner.instruction import TASKS, Instruction
from scenarios.loop.person.guided_arm import GuidedArm
from scenarios.loop.person.inbox import Heard


@dataclass(frozen=True, kw_only=True)
class Command:
    joints: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Observation:
    joints: np.ndarray
    tips_endoscope: np.ndarray
    forces_n: np.ndarray
    tools: tuple[str, str] = ("grasper", "scissors")
    clip_loaded: bool = False


@dataclass(frozen=True, kw_only=True)
class Event:
    event: str


@dataclass(frozen=True, kw_only=True)
class Outcome:
    events: tuple[Event, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Step:
    time_s: float
    instruction: Instruction
    command: Command
    exact: Observation
    outcome: Outcome
    applied: tuple[Event, ...] = ()
    altered: tuple[Entry, ...] = ()
    heard: tuple[Heard, ...] = ()
    told: tuple[str, ...] = ()
    guided: GuidedArm | None = None


def random_step(rng, number, instruction=None, events=(), **kept):
    return Step(
        time_s=number / 30,
        instruction=instruction or Instruction(task=TASKS[0]),
        command=Command(joints=rng.normal(size=(2, 7))),
        exact=Observation(
            joints=rng.normal(size=(2, 7)),
            tips_endoscope=rng.normal(size=(2, 4, 4)),
            forces_n=rng.normal(size=(2, 3)),
        ),
        outcome=Outcome(events=events),
        **kept,
    )
