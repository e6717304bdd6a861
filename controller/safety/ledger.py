"""The ledger: every command that was altered, and why."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One altered command, or one that a person had let pass against an interlock.

    Attributes:
        time_s: simulated.
        limits: names of what the command asked for would have broken, and where: "keep-out: right
            wrist to liver".
        margin: by how much, of the first of them; rad or m.
        change_m: how far the tip is from where it was asked to go, of the arm where it is farther.
        change_rad: of the joint that was changed most.
        held: the arms were held where they were.
        overridden: names of the interlocks that a person had set aside.
    """

    time_s: float
    limits: tuple[str, ...]
    margin: float = 0.0
    change_m: float = 0.0
    change_rad: float = 0.0
    held: bool = False
    overridden: tuple[str, ...] = ()
