"""Numbers as text for people."""

from __future__ import annotations

from scenarios.evaluation.report import Climb
from scenarios.evaluation.sensed import SensedFigures
from scenarios.loop.results import Summary

NOTHING = "–"
SENSED = (
    "sense", "episodes", "near", "90 %", "worst", "from the tip", "clips", "counted", "cuts",
    "in 95 %", "hidden",
)  # fmt: skip
"""Headings of `sensed`; errors in mm."""


def passed(summary: Summary) -> str:
    """Return how many episodes passed, of those that count."""
    return f"{summary.passed} of {summary.counted}"


def counts(summary: Summary) -> str:
    """Return how many episodes passed, of those that count; and how many called rightly."""
    told = passed(summary)
    return f"{told}, {summary.rightly_called} rightly called" if summary.rightly_called else told


def called(summary: Summary) -> str:
    """Return how many episodes called for a person, their share, and how many without need."""
    if not summary.called:
        return "0"
    told = f"{summary.called} ({rate(summary.called / summary.episodes)})"
    return f"{told}, {summary.needless} without need" if summary.needless else told


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


def signed(value: float | None, digits: int = 3, scale: float = 1.0) -> str:
    """Return a number with its sign."""
    return NOTHING if value is None else f"{scale * value:+z.{digits}f}"


def interval(ends: tuple[float, float] | None, digits: int, scale: float = 1.0) -> str:
    """Return both ends of an interval."""
    if ends is None:
        return NOTHING
    low, high = ends
    return f"{scale * low:z.{digits}f} to {scale * high:z.{digits}f}"


def sensed(figures: SensedFigures) -> tuple[str, ...]:
    """Return the figures of the observations' errors."""
    errors = (
        figures.near_m,
        figures.near_p90_m,
        figures.worst_m,
        figures.from_tip_m,
        figures.clips_m,
    )
    shares = (figures.clips_counted, figures.cuts_seen, figures.within_95, figures.hidden)
    return (
        figures.sense,
        str(figures.episodes),
        *(number(error, 2, 1e3) for error in errors),
        *(NOTHING if share is None else f"{share:.1%}" for share in shares),
    )
