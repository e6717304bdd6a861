"""Numbers as text for people."""

from __future__ import annotations

from scenarios.evaluation.report import Climb
from scenarios.loop.results import Summary

NOTHING = "–"


def passed(summary: Summary) -> str:
    """Return how many episodes passed, of those that count."""
    return f"{summary.passed} of {summary.counted}"


def counts(summary: Summary, missing: int = 0) -> str:
    """Return how many episodes passed, of those that count, and the numbers of the others."""
    told = [passed(summary)]
    told += [f"{summary.rightly_called} rightly called"] if summary.rightly_called else []
    told += [f"{summary.errors} error{'s' * (summary.errors > 1)}"] if summary.errors else []
    told += [f"{missing} not run"] if missing else []
    return ", ".join(told)


def end_of(climb: Climb) -> str:
    """Return the end of a climb: it broke, the planner called on every patient, or the top held."""
    if climb.breaking is not None:
        return f"breaks at {climb.breaking:g}"
    if climb.declined is not None:
        return f"calls at {climb.declined:g}"
    return "holds" if climb.finished else "not finished"


def held(climb: Climb) -> str:
    """Return the largest magnitude that held; a dash if the first rung is not judged yet."""
    if climb.held is not None:
        return f"{climb.held:g}"
    return "nothing" if climb.finished else NOTHING


def number(value: float | None, digits: int, scale: float = 1.0) -> str:
    """Return a number with `digits` decimals; a dash for None."""
    return NOTHING if value is None else f"{scale * value:z.{digits}f}"


def rate(value: float | None) -> str:
    """Return a rate in per cent."""
    return NOTHING if value is None else f"{100.0 * value:z.0f} %"


def signed(value: float | None, digits: int, scale: float = 1.0) -> str:
    """Return a number with its sign."""
    return NOTHING if value is None else f"{scale * value:+z.{digits}f}"


def interval(ends: tuple[float, float] | None, digits: int, scale: float = 1.0) -> str:
    """Return both ends of an interval."""
    if ends is None:
        return NOTHING
    low, high = ends
    return f"{scale * low:z.{digits}f} to {scale * high:z.{digits}f}"
