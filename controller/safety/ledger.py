"""The ledger: every command that the filter altered, and why."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One altered command, or one that passed because a person overrode an interlock.

    Attributes:
        time_s: simulated.
        limits: names of the limits that the wanted command breaks, and where: "keep-out: right
            wrist to liver".
        margin: by how much it breaks the first of them; rad or m.
        change_m: distance of the tip from its wanted place, of the arm with the larger one.
        change_rad: change of the joint that was changed most.
        held: both arms held their pose.
        overridden: names of the interlocks that a person overrode.
    """

    time_s: float
    limits: tuple[str, ...]
    margin: float = 0.0
    change_m: float = 0.0
    change_rad: float = 0.0
    held: bool = False
    overridden: tuple[str, ...] = ()
