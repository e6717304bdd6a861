"""Define acts that a person forbids until a person allows them again."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Literal, get_args

from planner.procedure.task import Task
from planner.scene.duct_side import structure_seen, tube_of
from planner.scene.next_task import clips_needed_on, clips_on
from planner.scene.predicates import OPEN_RAD
from tissue_sim.patient.tube_names import STRUCTURES, TUBES
from tissue_sim.sensing.observation import Observation

Act = Literal["clip", "cut", "open"]
ACTS: tuple[Act, ...] = get_args(Act)
_ALL_OF = {"clip": STRUCTURES, "cut": STRUCTURES, "open": ("left gripper", "right gripper")}


@dataclass(frozen=True, kw_only=True)
class Prohibition:
    """An act that must not be done.

    Attributes:
        act: The forbidden act.
        on: "duct", "artery", "second artery", "left tube", "right tube", "third tube", "left
            gripper" or "right gripper"; "" for any.
    """

    act: Act
    on: str = ""

    @property
    def text(self) -> str:
        """Return the prohibition in words: "no cut duct"."""
        return f"no {self.in_words}"

    @property
    def in_words(self) -> str:
        """Return the forbidden act in words: "cut duct"."""
        return f"{self.act} {self.on}".strip()

    def seen(self, observation: Observation) -> Prohibition:
        """Return the prohibition with a tube replaced by the structure observed there."""
        for tube in TUBES:
            if self.on == f"{tube} tube":
                return replace(self, on=structure_seen(tube, observation))
        return self

    def covers(self, other: Prohibition) -> bool:
        """Return whether this prohibition, or allowance, includes the other one."""
        return self.act == other.act and self.on in ("", other.on)

    def is_possible(self, observation: Observation) -> bool:
        """Return whether the act's tube is there; other acts are always possible."""
        tube = tube_of(self.on, observation) if self.on in STRUCTURES else None
        return tube is None or tube in observation.tubes

    def without(self, allowed: Prohibition) -> tuple[Prohibition, ...]:
        """Return the rest after an allowance: "clip duct" is no part of "clip" any more.

        A second artery that is not seen yet stays forbidden.
        """
        if allowed.covers(self):
            return ()
        if not self.covers(allowed):
            return (self,)
        return tuple(replace(self, on=one) for one in _ALL_OF[self.act] if one != allowed.on)


def act_of(task: Task, observation: Observation) -> Prohibition | None:
    """Return the act of a task as a prohibition; None if the task only grabs or retracts."""
    if task.deed is None or task.tube is None:
        return None
    return Prohibition(act=task.deed, on=structure_seen(task.tube, observation))


def unmeant_by(
    bans: Collection[Prohibition], task: Task, observation: Observation
) -> Prohibition | None:
    """Return the due act of a task, where bans on clips or cuts do not cover the act.

    A person who forbids a clip or a cut while another one is due may mean the due one.
    """
    due = act_of(task, observation)
    seen = [ban.seen(observation) for ban in bans if ban.act != "open"]
    return due if seen and due and not any(ban.covers(due) for ban in seen) else None


def already_so(ban: Prohibition, observation: Observation) -> str:
    """Return the part of a ban that comes too late: "The duct is cut already."; "" if none."""
    named = ban.seen(observation).on
    if ban.act == "open":
        arms = [k for k, side in enumerate(("left", "right")) if named == f"{side} gripper"]
        is_open = any(observation.joints[k, -1] >= OPEN_RAD for k in arms)
        return f"The {named} is open already." if is_open else ""
    if named not in STRUCTURES:
        return ""
    tube = tube_of(named, observation)
    if tube not in observation.tubes:
        return f"There is no {tube} tube here."
    if observation.is_severed(tube):
        return f"The {named} is cut already."
    n = clips_on(tube, observation)
    has_all = ban.act == "clip" and n >= clips_needed_on(tube, observation)
    return f"The {named} has its {n} clips already." if has_all else ""


def unmeant_in_words(
    bans: Collection[Prohibition], due: Prohibition, observation: Observation
) -> str:
    """Return in words the act that was due instead of the forbidden act."""
    ban = next(one for one in bans if one.act != "open").seen(observation)
    forbidden = f"the {ban.on}" if ban.act == due.act else f"to {ban.act} the {ban.on}"
    return f"I was about to {due.act} the {due.on}, not {forbidden}: that is not forbidden."
