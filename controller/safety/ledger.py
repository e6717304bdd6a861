"""Keep the ledger: every stretch of commands that the filter altered, with the reason."""

from __future__ import annotations

from dataclasses import dataclass, replace

APART_S = 0.5  # alterations within this time of each other, for the same reason, are one entry


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One altered command, several for the same reason, or a command that a person let pass.

    Attributes:
        time_s: Simulated time of the first command.
        until_s: Time of the last command; None if the last command is the first.
        commands: Number of altered commands.
        limits: Names of the limits that the wanted commands break, and how the limits were kept,
            as in "keep-out: scissors kept off the liver".
        margin: Largest excess over the first of these limits, in rad or m. For "on the way" it is
            the share of the motion that was withheld.
        nearest_m: Smallest distance to an obstacle that an instrument is kept off; None if there
            is none.
        change_m: Distance of the tip from its wanted place, of the arm with the larger distance.
        change_rad: Change of the joint that was changed most.
        held: Whether both arms held their pose, if only for one command.
        overridden: Names of the interlocks that a person overrode.
    """

    time_s: float
    until_s: float | None = None
    commands: int = 1
    limits: tuple[str, ...]
    margin: float = 0.0
    nearest_m: float | None = None
    change_m: float = 0.0
    change_rad: float = 0.0
    held: bool = False
    overridden: tuple[str, ...] = ()

    @property
    def end_s(self) -> float:
        """Return the time of the last command."""
        return self.time_s if self.until_s is None else self.until_s

    @property
    def words(self) -> str:
        """Return the entry as a surgeon reads it: "scissors kept off the liver, 1.2 mm"."""
        reasons = [_reason(limit) for limit in self.limits]
        overridden = [f"allowed by a person: {name}" for name in self.overridden]
        size = [] if self.nearest_m is None else [f"{1e3 * self.nearest_m:.1f} mm"]
        return ", ".join([*dict.fromkeys(reasons), *size, *overridden])

    def continues(self, before: Entry) -> bool:
        """Return whether this entry continues the event of an earlier entry."""
        same = not set(self.limits).isdisjoint(before.limits) or self.limits == before.limits
        locks = self.overridden == before.overridden
        return same and locks and self.time_s - before.end_s <= APART_S


class Ledger:
    """Collects the entries of an episode.

    Attributes:
        entries: The entries, in the order in which they began.
    """

    def __init__(self) -> None:
        self.entries: list[Entry] = []

    def note(self, entry: Entry) -> int:
        """Take in an altered command; return the index of its entry, old or new."""
        for k in reversed(range(len(self.entries))):
            if entry.continues(self.entries[k]):
                self.entries[k] = _joined(self.entries[k], entry)
                return k
        self.entries.append(entry)
        return len(self.entries) - 1


def _reason(limit: str) -> str:
    """Return how a limit was kept, with its name unless the rest describes the instrument."""
    name, _, how = limit.partition(": ")
    return how if name == "standstill" or "kept " in how or "slowed" in how else limit


def _joined(before: Entry, entry: Entry) -> Entry:
    distances = [d for d in (before.nearest_m, entry.nearest_m) if d is not None]
    return replace(
        before,
        until_s=entry.end_s,
        commands=before.commands + entry.commands,
        limits=tuple(dict.fromkeys((*before.limits, *entry.limits))),
        margin=max(before.margin, entry.margin),
        nearest_m=min(distances, default=None),
        change_m=max(before.change_m, entry.change_m),
        change_rad=max(before.change_rad, entry.change_rad),
        held=before.held or entry.held,
    )
