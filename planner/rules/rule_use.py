"""How often a hand-written rule has changed what a network decided, and by how much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable


@dataclass(frozen=True, kw_only=True)
class RuleUse:
    """The use of one rule in an episode.

    Attributes:
        policy: "planner" or "controller".
        rule: its name in docs/rules.md.
        decisions: number of decisions, or chunks, that the rule could change.
        changed: number of these that it changed.
        most_m: largest displacement of a tip that it added to a chunk; None for a planner's rule.
        most_rad: largest change of a jaw's angle that it made; likewise.
    """

    policy: str
    rule: str
    decisions: int
    changed: int
    most_m: float | None = None
    most_rad: float | None = None

    @property
    def share(self) -> float:
        """Return the share of decisions that the rule changed."""
        return self.changed / self.decisions if self.decisions else 0.0


@runtime_checkable
class Ruled(Protocol):
    """A policy whose network is overruled by rules."""

    def rule_uses(self) -> tuple[RuleUse, ...]:
        """Return the use of each rule since the episode began."""
        ...
