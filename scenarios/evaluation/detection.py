"""Measure how well a planner's chance of failure predicts failed episodes, as in SAFE.

Gu et al., "SAFE: Multitask failure detection for vision-language-action models", arXiv 2506.09937.
An episode's score is the highest chance in it. The area under the ROC curve of the scores measures
how well they separate failures from passes. The conformal alarm's measure is the share of failures
that raise it, where at most `FALSE_ALARMS` of the passes raise it. SAFE's threshold changes with
time; the threshold here does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import median

from scenarios.loop.results import EpisodeResult

FALSE_ALARMS = 0.05  # of passed episodes, at most, on average over calibration sets


@dataclass(frozen=True, kw_only=True)
class Share:
    """A share `count` of `of`."""

    count: int
    of: int

    @property
    def rate(self) -> float | None:
        """Return the share; None if `of` is 0."""
        return self.count / self.of if self.of else None


@dataclass(frozen=True, kw_only=True)
class Alarm:
    """The right and wrong alarms of a detector.

    Attributes:
        caught: Share of the failed episodes that raised an alarm.
        false: Share of the passed episodes that raised an alarm.
        lead_s: Median time from the alarm to the failed episode's end; None if none was caught.
    """

    caught: Share
    false: Share
    lead_s: float | None = None


@dataclass(frozen=True, kw_only=True)
class Detection:
    """Failure detection of one system.

    Attributes:
        passed, failed: Number of episodes in which the planner gave a chance.
        roc_auc: None without passes or without failures.
        roc: Shares (false alarms, caught), for every threshold.
        own: The planner's alarm, whose threshold holds for each task.
        conformal: The alarm for whole episodes, calibrated on every other pass and judged on the
            rest. None if too few passed for a threshold that keeps `FALSE_ALARMS`.
    """

    passed: int
    failed: int
    roc_auc: float | None
    roc: tuple[tuple[float, float], ...]
    own: Alarm
    conformal: Alarm | None


def detection(results: Sequence[EpisodeResult]) -> Detection | None:
    """Score the episodes that passed or failed; return None if the planner gave no chance.

    The order of `results` must not depend on their outcomes.
    """
    scored = [r for r in results if r.is_judged and score(r) is not None]
    if not scored:
        return None
    passes, failures = [r for r in scored if r.success], [r for r in scored if not r.success]
    leads_s = [_end_s(r) - s for r in failures if (s := _alarm_s(r)) is not None]
    curve = roc([score(r) or 0.0 for r in passes], [score(r) or 0.0 for r in failures])
    return Detection(
        passed=len(passes),
        failed=len(failures),
        roc_auc=area(curve) if passes and failures else None,
        roc=curve,
        own=Alarm(
            caught=_share([_alarm_s(r) is not None for r in failures]),
            false=_share([_alarm_s(r) is not None for r in passes]),
            lead_s=median(leads_s) if leads_s else None,
        ),
        conformal=_conformal(passes, failures),
    )


def score(result: EpisodeResult) -> float | None:
    """Return the highest chance of failure that the planner gave in an episode."""
    chances = (task.failure_chance for task in result.tasks)
    return max((chance for chance in chances if chance is not None), default=None)


def roc(passes: Sequence[float], failures: Sequence[float]) -> tuple[tuple[float, float], ...]:
    """Return the ROC curve from (0, 0) to (1, 1): shares of passes and failures by threshold."""
    thresholds = sorted({*passes, *failures}, reverse=True)
    return (
        (0.0, 0.0),
        *((_above(passes, at), _above(failures, at)) for at in thresholds),
    )


def area(curve: Sequence[tuple[float, float]]) -> float:
    """Return the area under the curve: the chance that a failure scores higher, ties by half."""
    return sum((x1 - x0) * 0.5 * (y0 + y1) for (x0, y0), (x1, y1) in pairwise(curve))


def _conformal(passes: Sequence[EpisodeResult], failures: Sequence[EpisodeResult]) -> Alarm | None:
    import numpy as np

    from planner.learned.calibration import conformal_quantile

    known, fresh = passes[::2], passes[1::2]
    threshold = conformal_quantile(np.array([score(r) for r in known], float), FALSE_ALARMS)
    if threshold >= 1.0:
        return None
    return Alarm(
        caught=_share([(score(r) or 0.0) > threshold for r in failures]),
        false=_share([(score(r) or 0.0) > threshold for r in fresh]),
    )


def _above(scores: Sequence[float], threshold: float) -> float:
    return sum(score >= threshold for score in scores) / len(scores) if scores else 0.0


def _share(hits: Sequence[bool]) -> Share:
    return Share(count=sum(hits), of=len(hits))


def _alarm_s(result: EpisodeResult) -> float | None:
    return min((t.alarm_s for t in result.tasks if t.alarm_s is not None), default=None)


def _end_s(result: EpisodeResult) -> float:
    return result.procedure_time_s + result.exchange_time_s
