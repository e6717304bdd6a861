"""The ledger: every stretch of commands that the filter altered, and why."""

from __future__ import annotations

from dataclasses import dataclass, replace

APART_S = 0.5  # alterations within this time of each other, for the same reason, are one entry


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One altered command, or several for the same reason, or one that a person had pass.

    Attributes:
        time_s: simulated, of the first command.
        until_s: of the last command; None if it is the first.
        commands: how many were altered.
        limits: names of the limits that the wanted commands break, and how they were kept:
            "keep-out: scissors kept off the liver".
        margin: by how much the first of them was broken at most; rad or m, of "on the way" the
            share of the motion that was withheld.
        nearest_m: smallest distance to what an instrument is kept off; None if to nothing.
        change_m: distance of the tip from its wanted place, of the arm with the larger one.
        change_rad: change of the joint that was changed most.
        held: both arms held their pose, if only for one command.
        overridden: names of the interlocks that a person overrode.
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
        """Return whether this is the same event as an entry before, which goes on."""
        same = not set(self.limits).isdisjoint(before.limits) or self.limits == before.limits
        locks = self.overridden == before.overridden
        return same and locks and self.time_s - before.end_s <= APART_S


class Ledger:
    """Collects the entries of an episode.

    Attributes:
        entries: in the order in which they began.
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
    """Return how a limit was kept, with its name unless that says what the instrument did."""
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
