"""Measure a learned planner's accuracy on rollouts outside its training set, and its speed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

import numpy as np
import torch
from rich.table import Table

from controller.dataset.rollouts import rollouts
from planner.learned.network import CHECKPOINTS, PlannerNetwork
from planner.learned.rollout import EVERY, Rollout, Rollouts
from planner.learned.scoring import PlannerScore, score
from planner.learning.checkpoint import CheckpointError
from scenarios.files.errors import BadInputError, refusing
from scenarios.files.outside_text import table_of

REPEATS = 300


def bench_planner(*, planner_checkpoint: Path | None, data: Sequence[Path]) -> list[Table]:
    """Score the planner on the rollouts of learned controllers in these datasets.

    Raises:
        BadInputError: The checkpoint does not fit, or the data holds no such rollout.
    """
    torch.set_num_threads(1)
    with refusing(CheckpointError, before="--planner-checkpoint: "):
        network = CHECKPOINTS.load(planner_checkpoint)
    with refusing(ValueError):
        given = [r for r in rollouts(data) if r.learned]
    if not given:
        raise BadInputError("--data: no rollout in it; `calot collect --mix rollouts` makes some")
    return [_table(score(network, given), _times_ms(network, given[0]), len(given))]


def _table(found: PlannerScore, times_ms: np.ndarray, n: int) -> Table:
    median_ms, high_ms = np.percentile(times_ms, (50, 99))
    rows = {
        "task accuracy": f"{found.task_accuracy:.4f}",
        "flag: F1": f"{found.flag_f1:.3f}",
        "flag: precision, recall": f"{found.flag_precision:.3f}, {found.flag_recall:.3f}",
        "correction accuracy where wanted": f"{found.correction_accuracy:.3f}",
        "calibration error of the failure chance": f"{found.calibration_error:.3f}",
        f"alarm before {found.late_tasks} late tasks": f"{found.alarms_in_time:.3f}",
        "its lead, median (s)": f"{found.lead_s:.1f}",
        f"false alarms in {found.timely_tasks} timely tasks": f"{found.false_alarms:.3f}",
        "inference, one thread: median, p99 (ms)": f"{median_ms:.2f}, {high_ms:.2f}",
    }
    title = f"planner on {n} rollouts, {found.moments} moments"
    return table_of(title, ("figure",), ("value",), rows.items())


def _times_ms(network: PlannerNetwork, rollout: Rollout) -> np.ndarray:
    data = Rollouts([rollout], network.config.history)
    one = torch.ones(1, dtype=torch.int64)
    moments, times_ms = data.moments((len(data) - 1) * one, EVERY * one, one), []
    with torch.inference_mode():
        for _ in range(REPEATS):
            start_s = perf_counter()
            network(moments)
            times_ms.append(1e3 * (perf_counter() - start_s))
    return np.array(times_ms)
