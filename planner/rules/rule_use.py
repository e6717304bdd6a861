"""How often a hand-written rule has changed what a network decided, and by how much."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

ANY = "any rule"
"""The name under which a policy counts the decisions that at least one of its rules changed."""


@dataclass(frozen=True, kw_only=True)
class RuleUse:
    """The use of one rule in an episode.

    Attributes:
        policy: "planner" or "controller".
        rule: its name in docs/rules.md.
        decisions: number of decisions, or chunks, that the rule could change.
        changed: number of these that it changed.
        most_m: largest displacement of a tip that it added to a chunk; None for a planner's rule
            and before the first change.
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


class RuleCounts:
    """Counts what the rules of one policy change."""

    def __init__(self, policy: str, rules: Iterable[str]) -> None:
        self._uses = {
            rule: RuleUse(policy=policy, rule=rule, decisions=0, changed=0)
            for rule in (*rules, ANY)
        }

    def note(
        self,
        rule: str,
        *,
        changed: bool,
        moved_m: float | None = None,
        jaw_rad: float | None = None,
    ) -> None:
        """Add one decision.

        Args:
            rule: its name.
            changed: whether the rule changed the decision.
            moved_m: displacement of a tip that the rule added to a chunk.
            jaw_rad: change of a jaw's angle that it made.
        """
        use = self._uses[rule]
        self._uses[rule] = replace(
            use,
            decisions=use.decisions + 1,
            changed=use.changed + changed,
            most_m=_larger(use.most_m, moved_m),
            most_rad=_larger(use.most_rad, jaw_rad),
        )

    def uses(self) -> tuple[RuleUse, ...]:
        """Return the use of each rule so far."""
        return tuple(self._uses.values())


def _larger(before: float | None, now: float | None) -> float | None:
    return before if now is None else now if before is None else max(before, now)


def rule_uses_of(*policies: object) -> tuple[RuleUse, ...]:
    """Return the uses of the rules of those policies that have any."""
    ruled = (policy for policy in policies if isinstance(policy, Ruled))
    return tuple(use for policy in ruled for use in policy.rule_uses())


def total(uses: Iterable[RuleUse]) -> tuple[RuleUse, ...]:
    """Return the uses of several episodes added up, one for each rule, in their first order."""
    counts = dict[tuple[str, str], RuleUse]()
    for use in uses:
        before = counts.get((use.policy, use.rule), replace(use, decisions=0, changed=0))
        counts[use.policy, use.rule] = replace(
            use,
            decisions=before.decisions + use.decisions,
            changed=before.changed + use.changed,
            most_m=_larger(before.most_m, use.most_m),
            most_rad=_larger(before.most_rad, use.most_rad),
        )
    return tuple(counts.values())


@runtime_checkable
class Ruled(Protocol):
    """A policy whose network is overruled by rules."""

    def rule_uses(self) -> tuple[RuleUse, ...]:
        """Return the use of each rule since the episode began."""
        ...
