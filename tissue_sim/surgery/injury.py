"""Injuries, as events with a value and the limit that it exceeds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Injury:
    """Something that must not happen. The event defines the units of value and limit."""

    event: str
    time_s: float
    value: float
    limit: float


@dataclass(frozen=True, kw_only=True)
class LimitReading:
    """One quantity that may not exceed its limit."""

    event: str
    value: float
    limit: float


class InjuryMonitor:
    """Turns readings into events: one each time that a quantity newly exceeds its limit."""

    def __init__(self, events: Iterable[Injury] = (), broken: Iterable[str] = ()) -> None:
        self.events = list(events)
        self.broken = set(broken)

    def watch(self, readings: Iterator[LimitReading], time_s: float) -> None:
        """Add an event for each reading that newly exceeds its limit."""
        for reading in readings:
            if reading.value <= reading.limit:
                self.broken.discard(reading.event)
            elif reading.event not in self.broken:
                self.broken.add(reading.event)
                self.add(reading, time_s)

    def add(self, reading: LimitReading, time_s: float) -> None:
        """Add an event without a check."""
        self.events.append(
            Injury(event=reading.event, time_s=time_s, value=reading.value, limit=reading.limit)
        )
