"""Calibrate failure probabilities, and an alarm with a bounded rate of false alarms.

The logit of failure is scaled and shifted on episodes kept out of training (Platt, 1999). The alarm
is the conformal quantile of the highest probability within tasks done in time (Vovk et al., 2005).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional as F

from planner.learned.network import PlannerNetwork, Prediction
from planner.learned.rollout import EVERY, Rollout, Rollouts

FALSE_ALARMS = 0.05  # of tasks that are done in time
BATCH = 2_000


def calibrate(network: PlannerNetwork, rollouts: Sequence[Rollout]) -> None:
    """Set a network's calibration and alarm from episodes that it was not trained on."""
    data = Rollouts(rollouts, network.config.history)
    at = torch.arange(0, len(data), EVERY)
    fails = data.labels(at).fails
    with torch.inference_mode():
        logits = torch.cat([o.fails for o in predictions(network, data, at)])
    told = ~fails.isnan()
    network.calibration.copy_(fit_platt(logits[told], fails[told]))
    chances = (network.calibration[0] * logits + network.calibration[1]).sigmoid().numpy()
    highest = np.array([chances[rows].max() for rows in _tasks_done_in_time(data, at)])
    network.alarm.fill_(conformal_quantile(highest, FALSE_ALARMS))


def predictions(network: PlannerNetwork, data: Rollouts, at: Tensor) -> Iterator[Prediction]:
    """Yield a network's predictions at steps (n,), a batch at a time, as in an episode."""
    for some in at.split(BATCH):
        n = torch.ones_like(some)
        yield network(data.moments(some, EVERY * n, n))


def fit_platt(logits: Tensor, outcomes: Tensor) -> Tensor:
    """Return scale and shift (2,) of logits (n,), fitted to outcomes (n,) of 0 and 1."""
    given, wanted = logits.double().clone(), outcomes.double().clone()
    line = torch.tensor([1.0, 0.0], dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.LBFGS([line], max_iter=100, line_search_fn="strong_wolfe")

    def loss() -> Tensor:
        optimiser.zero_grad()
        value = F.binary_cross_entropy_with_logits(line[0] * given + line[1], wanted)
        value.backward()
        return value

    optimiser.step(loss)  # pyright: ignore[reportArgumentType]
    return line.detach().float()


def conformal_quantile(scores: NDArray, share: float) -> float:
    """Return a bound that a new score exceeds with chance `share` at most; 1 for too few scores."""
    rank = math.ceil((len(scores) + 1) * (1.0 - share))
    return float(np.sort(scores)[rank - 1]) if rank <= len(scores) else 1.0


def _tasks_done_in_time(data: Rollouts, at: Tensor) -> Iterator[NDArray[np.int64]]:
    """Yield the rows of `at` for each task, of each episode, that was done in time."""
    fails = data.labels(at).fails
    for rows in data.tasks(at):
        if (fails[rows] == 0).all():
            yield rows.numpy()
