"""Chances that mean what they say, and an alarm that is seldom false.

The logit of failure is scaled and shifted on episodes kept out of training (Platt, 1999); the alarm
is the conformal quantile of the highest chance within tasks that went well (Vovk et al., 2005).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional as F

from planner.learned.network import Opinion, PlannerNetwork
from planner.learned.rollout import EVERY, Rollout, Rollouts

FALSE_ALARMS = 0.05  # of tasks that are done in time
BATCH = 2_000


def calibrate(network: PlannerNetwork, rollouts: Sequence[Rollout]) -> None:
    """Set calibration and alarm of a network from episodes that it was not trained on."""
    data = Rollouts(rollouts, network.config.history)
    at = torch.arange(0, len(data), EVERY)
    fails = data.labels(at).fails
    with torch.inference_mode():
        logits = torch.cat([o.fails for o in opinions(network, data, at)])
    told = ~fails.isnan()
    network.calibration.copy_(fitted(logits[told], fails[told]))
    chances = (network.calibration[0] * logits + network.calibration[1]).sigmoid().numpy()
    highest = np.array([chances[rows].max() for rows in _tasks_done_in_time(data, at)])
    network.alarm.fill_(conformal_quantile(highest, FALSE_ALARMS))


def opinions(network: PlannerNetwork, data: Rollouts, at: Tensor) -> Iterator[Opinion]:
    """What a network that runs makes of steps (n,), a batch at a time."""
    for some in at.split(BATCH):
        n = torch.ones_like(some)
        yield network(data.moments(some, EVERY * n, n))


def fitted(logits: Tensor, outcomes: Tensor) -> Tensor:
    """Scale and shift (2,) under which logits (n,) foretell outcomes (n,) of 0 and 1 best."""
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
    """What a further score exceeds with a chance of `share` at most; 1 if there are too few."""
    rank = math.ceil((len(scores) + 1) * (1.0 - share))
    return float(np.sort(scores)[rank - 1]) if rank <= len(scores) else 1.0


def _tasks_done_in_time(data: Rollouts, at: Tensor) -> Iterator[NDArray[np.int64]]:
    """Rows of `at` for each task of each episode none of whose moments foresaw a failure."""
    labels, begin = data.labels(at), data.steps.begin[at]
    runs = torch.stack([begin, labels.task])
    starts = (runs[:, 1:] != runs[:, :-1]).any(dim=0).nonzero()[:, 0] + 1
    for rows in torch.tensor_split(torch.arange(len(at)), starts):
        if (labels.fails[rows] == 0).all():
            yield rows.numpy()
