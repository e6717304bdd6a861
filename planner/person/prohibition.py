"""What a person forbids until a person allows it again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from planner.seen.duct_side import duct_side
from planner.task import Task
from tissue_sim.sensing.observation import Observation

Act = Literal["clip", "cut", "open"]
ACTS: tuple[Act, ...] = get_args(Act)


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
        side = self.on.removesuffix(" tube")
        if side == self.on:
            return self
        structure = "duct" if side == duct_side(observation) else "artery"
        return Prohibition(act=self.act, on=structure)

    def covers(self, other: Prohibition) -> bool:
        """Return whether who forbids, or allows, this does so for the other."""
        return self.act == other.act and self.on in ("", other.on)


def act_of(task: Task, observation: Observation) -> Prohibition | None:
    """Return the act of a task, as it would be forbidden; None if it only grabs or goes back."""
    if task.kind not in ("clip", "cut") or task.tube is None:
        return None
    on = "duct" if task.tube == duct_side(observation) else "artery"
    return Prohibition(act="clip" if task.kind == "clip" else "cut", on=on)
