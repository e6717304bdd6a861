"""What a person forbids until a person allows it again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

from planner.command import TUBES
from planner.seen.duct_side import structure_seen
from planner.task import Task
from tissue_sim.sensing.observation import Observation

Act = Literal["clip", "cut", "open"]
ACTS: tuple[Act, ...] = get_args(Act)
_OTHER = {
    "duct": "artery", "artery": "duct", "left tube": "right tube", "right tube": "left tube",
    "left gripper": "right gripper", "right gripper": "left gripper",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Prohibition:
    """An act that must not be done.

    Attributes:
        act: what.
        on: "duct", "artery", "left tube", "right tube", "left gripper" or "right gripper"; "" for
            any.
    """

    act: Act
    on: str = ""

    @property
    def text(self) -> str:
        """Return it in words: "no cut duct"."""
        return f"no {self.in_words}"

    @property
    def in_words(self) -> str:
        """Return what is forbidden: "cut duct"."""
        return f"{self.act} {self.on}".strip()

    def seen(self, observation: Observation) -> Prohibition:
        """Return it with a tube replaced by the structure that is seen there."""
        for tube in TUBES:
            if self.on == f"{tube} tube":
                return replace(self, on=structure_seen(tube, observation))
        return self

    def covers(self, other: Prohibition) -> bool:
        """Return whether who forbids, or allows, this does so for the other."""
        return self.act == other.act and self.on in ("", other.on)

    def without(self, allowed: Prohibition) -> tuple[Prohibition, ...]:
        """Return what is left where a part is allowed: "cut" without "cut duct": "cut artery"."""
        if allowed.covers(self):
            return ()
        return (replace(self, on=_OTHER[allowed.on]) if self.covers(allowed) else self,)


def act_of(task: Task, observation: Observation) -> Prohibition | None:
    """Return the act of a task, as it would be forbidden; None if it only grabs or goes back."""
    if task.kind not in ("clip", "cut") or task.tube is None:
        return None
    return Prohibition(act=task.kind, on=structure_seen(task.tube, observation))
