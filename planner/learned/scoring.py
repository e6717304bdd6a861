"""Score a learned planner on rollouts that it was not trained on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from planner.learned.calibration import predictions
from planner.learned.network import PlannerNetwork, Prediction
from planner.learned.rollout import EVERY, NOT_SAID, Rollout, Rollouts
from tissue_sim.constants import CONTROL_HZ

BINS = 10


@dataclass(frozen=True, kw_only=True)
class PlannerScore:
    """The score over moments a second apart.

    Attributes:
        moments: Number of moments.
        task_accuracy: Share of moments with the right task.
        flag_precision, flag_recall: Scores of needed corrections, NaN if there is none.
        correction_accuracy: Share of needed corrections with the right correction.
        calibration_error: Mean gap between failure probability and failure rate (10 bins).
        alarms_in_time: Share of tasks not done in time that an alarm predicted.
        lead_s: Median time from such an alarm to the last moment at which failure is predictable.
        false_alarms: Share of tasks done in time that had an alarm.
        late_tasks, timely_tasks: Numbers of tasks not done in time, and done in time.
    """

    moments: int
    task_accuracy: float
    flag_precision: float
    flag_recall: float
    correction_accuracy: float
    calibration_error: float
    alarms_in_time: float
    lead_s: float
    false_alarms: float
    late_tasks: int
    timely_tasks: int

    @property
    def flag_f1(self) -> float:
        """Return the harmonic mean of precision and recall."""
        both = self.flag_precision + self.flag_recall
        return 2.0 * self.flag_precision * self.flag_recall / both if both else float("nan")


def score(network: PlannerNetwork, rollouts: Sequence[Rollout]) -> PlannerScore:
    """Return the score of a network's predictions on rollouts against their targets."""
    data = Rollouts(rollouts, network.config.history)
    at = torch.arange(0, len(data), EVERY)
    with torch.inference_mode():
        parts = list(predictions(network, data, at))
        predicted = Prediction(*(torch.cat(part) for part in zip(*parts, strict=True)))
        chances = network.failure_chance(predicted).numpy()
    labels = data.labels(at)
    wanted, flagged = labels.correction != NOT_SAID, predicted.flag > 0.0
    right = (predicted.correction.argmax(dim=-1) == labels.correction)[wanted]
    told = ~labels.fails.isnan().numpy()
    tasks = list(_tasks(data, at, chances > network.alarm.item()))
    late, timely = [t for t in tasks if t.late], [t for t in tasks if not t.late]
    leads_s = [t.lead_s for t in late if t.lead_s is not None]
    return PlannerScore(
        moments=len(at),
        task_accuracy=_share(predicted.task.argmax(dim=-1) == labels.task),
        flag_precision=_share(wanted[flagged]),
        flag_recall=_share(flagged[wanted]),
        correction_accuracy=_share(right),
        calibration_error=calibration_error(chances[told], labels.fails.numpy()[told]),
        alarms_in_time=len(leads_s) / len(late) if late else float("nan"),
        lead_s=float(np.median(leads_s)) if leads_s else float("nan"),
        false_alarms=_share([t.alarmed for t in timely]),
        late_tasks=len(late),
        timely_tasks=len(timely),
    )


def calibration_error(chances: NDArray, outcomes: NDArray) -> float:
    """Return the expected calibration error of probabilities (n,) for outcomes (n,) of 0 and 1.

    The definition is that of Guo et al., arXiv 1706.04599, equation 3, with bins of equal width.
    """
    bins = np.minimum((chances * BINS).astype(int), BINS - 1)
    gaps = [
        (bins == k).mean() * abs(chances[bins == k].mean() - outcomes[bins == k].mean())
        for k in np.unique(bins)
    ]
    return float(sum(gaps))


@dataclass(frozen=True, kw_only=True)
class _Task:
    """One task of one rollout.

    Attributes:
        late: Whether the task was not done in time.
        alarmed: Whether there was an alarm.
        lead_s: Time from the first alarm to the last moment at which failure is predictable.
    """

    late: bool
    alarmed: bool
    lead_s: float | None


def _tasks(data: Rollouts, at: torch.Tensor, alarms: NDArray[np.bool_]) -> Iterator[_Task]:
    """Yield each task of each rollout whose result is known."""
    known = data.labels(at).fails
    for rows in data.tasks(at):
        fails = known[rows]
        if fails.isnan().any():
            continue
        late, alarmed = bool(fails.any()), alarms[rows.numpy()]
        lead_s = _lead_s(int(fails.nonzero()[-1]), alarmed) if late else None
        yield _Task(late=late, alarmed=bool(alarmed.any()), lead_s=lead_s)


def _lead_s(too_late: int, alarmed: NDArray[np.bool_]) -> float | None:
    """Return the time from the first alarm to the last moment at which failure is predictable."""
    first = np.flatnonzero(alarmed[: too_late + 1])
    return float(too_late - first[0]) * EVERY / CONTROL_HZ if len(first) else None


def _share(hits: torch.Tensor | Sequence[bool]) -> float:
    values = np.asarray(hits, dtype=float)
    return float(values.mean()) if len(values) else float("nan")
