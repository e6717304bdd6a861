"""Define injuries as events with a value and the limit that the value exceeds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Injury:
    """An event that must not happen. The event defines the units of value and limit."""

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

    @property
    def demand(self) -> float:
        """Return the value over its limit; a result above 1 is an injury.

        Raises:
            ZeroDivisionError: the limit is 0, a quantity without tolerance.
        """
        return self.value / self.limit


class InjuryMonitor:
    """Turns readings into events, one each time that a quantity newly exceeds its limit.

    Attributes:
        events: The injuries so far.
        broken: Names of the limits that are currently exceeded.
        peaks: For each event, the reading that came nearest to its limit, or went furthest beyond
            it. An event without tolerance (limit 0) has no peak.
    """

    def __init__(
        self,
        events: Iterable[Injury] = (),
        broken: Iterable[str] = (),
        peaks: Iterable[LimitReading] = (),
    ) -> None:
        self.events = list(events)
        self.broken = set(broken)
        self.peaks = {peak.event: peak for peak in peaks}

    def watch(self, readings: Iterator[LimitReading], time_s: float) -> None:
        """Add an event for each reading that newly exceeds its limit, and keep its peak."""
        for reading in readings:
            self._keep_peak(reading)
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

    def _keep_peak(self, reading: LimitReading) -> None:
        if reading.limit <= 0.0:
            return
        peak = self.peaks.get(reading.event)
        if peak is None or reading.demand > peak.demand:
            self.peaks[reading.event] = reading
