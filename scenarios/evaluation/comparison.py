"""Compare two systems on the same patients: pass rates, and measures where both pass."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from scenarios.evaluation.case import Case
from scenarios.evaluation.figures import jerk_m, path_m
from scenarios.evaluation.paired import (
    Interval,
    mcnemar_exact,
    mean_interval,
    tango_interval,
)
from scenarios.loop.results import EpisodeResult

Place = tuple[str, str, int]  # suite, condition, seed

MEASURES: dict[str, Callable[[EpisodeResult], float | None]] = {
    "time_s": lambda r: r.procedure_time_s,
    "path_m": path_m,
    "jerk_m": lambda r: jerk_m(r.tasks),
    "corrections": lambda r: float(r.corrections),
    "clearance_m": lambda r: r.safety.min_clearance_m,
}
"""The measures that are compared where both systems pass."""


@dataclass(frozen=True, kw_only=True)
class PairedDifference:
    """A measure's difference, first system minus second.

    Attributes:
        interval_95: Interval of the mean; None for fewer than two pairs.
    """

    measure: str
    pairs: int
    mean: float
    interval_95: Interval | None


@dataclass(frozen=True, kw_only=True)
class ArmComparison:
    """A system compared with the reference system in one suite.

    Attributes:
        pairs: Patients under a condition that count for both systems. In neither episode was a
            person called rightly, and neither broke off.
        both, neither, only_arm, only_reference: Number of pairs by the systems that passed.
        difference: Difference of the pass rates, system minus reference; None without pairs.
        tango_95: Interval of the difference.
        mcnemar_p: Exact, two-sided.
        where_both_pass: Paired differences of other measures.
    """

    arm: str
    reference: str
    suite: str
    pairs: int
    both: int
    neither: int
    only_arm: int
    only_reference: int
    difference: float | None
    tango_95: Interval
    mcnemar_p: float
    where_both_pass: tuple[PairedDifference, ...]


def compare(
    arm: str, reference: str, suite: str, results: Mapping[Case, EpisodeResult]
) -> ArmComparison:
    """Compare both systems over the conditions and patients that both met."""
    mine, its = (_of(name, suite, results) for name in (arm, reference))
    pairs = [(mine[place], its[place]) for place in mine if place in its]
    if any(a.anatomy_hash != b.anatomy_hash for a, b in pairs):
        raise ValueError(f"{arm} and {reference} met different patients under one seed")
    passed = [(a.success, b.success) for a, b in pairs]
    only_arm, only_reference = passed.count((True, False)), passed.count((False, True))
    n = len(pairs)
    return ArmComparison(
        arm=arm,
        reference=reference,
        suite=suite,
        pairs=n,
        both=passed.count((True, True)),
        neither=passed.count((False, False)),
        only_arm=only_arm,
        only_reference=only_reference,
        difference=(only_arm - only_reference) / n if n else None,
        tango_95=tango_interval(only_arm, only_reference, n),
        mcnemar_p=mcnemar_exact(only_arm, only_reference),
        where_both_pass=_differences([(a, b) for a, b in pairs if a.success and b.success]),
    )


def _of(arm: str, suite: str, results: Mapping[Case, EpisodeResult]) -> dict[Place, EpisodeResult]:
    """Return a system's episodes that count."""
    return {
        (case.suite, case.condition.name, case.seed): result
        for case, result in results.items()
        if (case.arm.name, case.suite) == (arm, suite) and result.is_counted
    }


def _differences(
    pairs: list[tuple[EpisodeResult, EpisodeResult]],
) -> tuple[PairedDifference, ...]:
    found = []
    for name, measure in MEASURES.items():
        both = [(measure(a), measure(b)) for a, b in pairs]
        apart = [a - b for a, b in both if a is not None and b is not None]
        if apart:
            found.append(
                PairedDifference(
                    measure=name,
                    pairs=len(apart),
                    mean=sum(apart) / len(apart),
                    interval_95=mean_interval(apart),
                )
            )
    return tuple(found)
