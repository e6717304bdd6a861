"""Define the kinds of task: what a kind does, whatever structure it is for.

A kind of task has an entry in four visible tables: `KINDS` here, its criterion in the world in
`planner.procedure.outcomes.OUTCOMES`, its criterion by observation in
`planner.scene.observed_outcomes.OBSERVED`, and the expert's skill in
`controller.expert.skills.SKILLS`. No other module compares a kind's name: each asks what it does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeVar

Deed = Literal["clip", "cut"]
Entry = TypeVar("Entry")


@dataclass(frozen=True, kw_only=True)
class TaskKind:
    """A kind of task.

    Attributes:
        grasps: Whether the left arm takes hold of the gallbladder; otherwise the right arm works.
        deed: What the right tool does to tissue for good; None if nothing.
        goes_back: Whether the right arm only retracts.
        typical_s: Usual duration; None if nobody has measured it.
    """

    grasps: bool = False
    deed: Deed | None = None
    goes_back: bool = False
    typical_s: float | None = None


# Durations are means of 16 procedures that passed (`textbook`, learned policies, seeds 12000 to
# 12009 by `tracked`, six more by cameras).
KINDS: dict[str, TaskKind] = {
    "grab": TaskKind(grasps=True, typical_s=7.4),
    "clip": TaskKind(deed="clip", typical_s=4.4),
    "go_back": TaskKind(goes_back=True, typical_s=2.7),
    "cut": TaskKind(deed="cut", typical_s=4.2),
    "go_back_from_cut": TaskKind(goes_back=True, typical_s=2.6),
}
"""Every kind of task, by its name."""


def entry_of(kind: str, table: Mapping[str, Entry], name: str) -> Entry:
    """Return a kind's entry in one of the tables of kinds.

    Args:
        kind: Name of the kind.
        table: The table.
        name: Name of the table.

    Raises:
        ValueError: The table lacks the kind; the message lists the kinds that the table has.
    """
    if kind not in table:
        raise ValueError(f"{name} has no entry for the kind {kind!r}; it has: {', '.join(table)}")
    return table[kind]
