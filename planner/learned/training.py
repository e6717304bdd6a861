"""Train the learned planner; a stopped training resumes exactly. Read the file top to bottom."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import torch
from torch import Tensor
from torch.nn import functional as F

from planner.base import MOST_TRIES
from planner.learned.calibration import calibrate
from planner.learned.features import N_CORRECTIONS, N_TASKS, VERY_LONG_S
from planner.learned.network import CHECKPOINTS, Moments, PlannerConfig, PlannerNetwork, Prediction
from planner.learned.rollout import ASKED_EVERY, Labels, Rollout, Rollouts
from planner.learning.optimise import Schedule, TrainingStep, learn
from planner.procedure.cholecystectomy import TASKS

CHECKPOINT_FILE = CHECKPOINTS.shipped.name
NORMALISE_BY = 20_000  # steps
KEEP_OUT_EVERY = 6  # patients
CHANGES, FLAGGED, DECLINED = 0.25, 0.2, 0.1  # of a batch; the rest is drawn from all steps
MISLED, UNTOLD = 0.2, 0.1  # of a batch: given a wrong task, or none
TRIED_OUT = 0.05  # of a batch: a task that has been given more often than it may; assumed
TASK_SHARE = 0.6  # of the loss; SRT-H's
MIN_WEIGHT = 1e-6  # of a batch in which nothing counts, so as not to divide by zero
FLAG_WEIGHT, CORRECTION_WEIGHT, PROGRESS_WEIGHT, FAILS_WEIGHT = 1.0, 0.5, 0.5, 0.5
CALLS_WEIGHT = 1.0


@dataclass(frozen=True, kw_only=True)
class PlannerTraining(Schedule):
    """The settings of a planner's training."""

    shape: ClassVar[str] = "planner"
    planner: PlannerConfig = field(default_factory=PlannerConfig)
    steps: int = 8_000
    batch: int = 256


PRESETS = {
    "full": PlannerTraining(),
    "smoke": PlannerTraining(
        planner=PlannerConfig(width=32, layers=1),
        steps=100,
        batch=64,
        warm_up=10,
        average=0.9,
        save_every=20,
    ),
}


def train(
    rollouts: Sequence[Rollout],
    config: PlannerTraining,
    out: Path,
    device: str = "cpu",
    base: PlannerNetwork | None = None,
) -> Iterator[TrainingStep]:
    """Train a planner, or resume the training in `out`, as `learn` does.

    At the end the checkpoint is calibrated on learned rollouts kept out of training. If these are
    of fewer than six patients, the calibration stays as it was.

    Raises:
        ValueError: There is no rollout, or as in `learn`.
    """
    training, kept_out = split_rollouts(rollouts)
    yield from learn(PlannerData, CHECKPOINTS, training, config, out, device, base)
    if kept_out:
        trained = CHECKPOINTS.load(out / CHECKPOINT_FILE)
        calibrate(trained, kept_out)
        CHECKPOINTS.save(out / CHECKPOINT_FILE, trained)


class PlannerData(Rollouts):
    """Rollouts to train on."""

    def __init__(self, rollouts: Sequence[Rollout], config: PlannerTraining, device: str) -> None:
        del device  # a planner is trained on the CPU

        super().__init__(rollouts, config.planner.history)
        self._config = config

    def normalise(self, network: PlannerNetwork, chance: torch.Generator) -> None:
        """Set the normalisation from some steps."""
        some = torch.randint(len(self), (NORMALISE_BY,), generator=chance)
        network.normalise_by(self.steps.states[some])

    def loss(self, network: PlannerNetwork, chance: torch.Generator) -> Tensor:
        """Return the loss of random moments: rare ones more often, words delayed, partly wrong."""
        n, (least, most) = self._config.batch, ASKED_EVERY
        at, weight = sample_steps(self, n, chance)
        every = torch.randint(least, most, (n,), generator=chance)
        lag = 1 + (torch.rand(n, generator=chance) * every).long()
        moments = _with_wrong_words(self.moments(at, every, lag), chance)
        moments, tried_out = with_many_tries(moments, chance)
        with torch.autocast("cpu", torch.bfloat16, enabled=self._config.bfloat16):
            prediction = network(moments)
        told = Prediction(*(part.float() for part in prediction))
        labels = self.labels(at)
        calls = torch.where(tried_out, 1.0, labels.calls)
        return loss_of(told, labels._replace(calls=calls), weight)


def split_rollouts(rollouts: Sequence[Rollout]) -> tuple[list[Rollout], list[Rollout]]:
    """Return rollouts for training, and for calibration the learned ones of every sixth patient."""
    patients = dict.fromkeys(r.patient for r in rollouts if r.learned)
    apart = set(list(patients)[KEEP_OUT_EVERY - 1 :: KEEP_OUT_EVERY])
    kept_out = [r.learned and r.patient in apart for r in rollouts]
    return (
        [r for r, out in zip(rollouts, kept_out, strict=True) if not out],
        [r for r, out in zip(rollouts, kept_out, strict=True) if out],
    )


def sample_steps(data: Rollouts, n: int, chance: torch.Generator) -> tuple[Tensor, Tensor]:
    """Draw steps (n,), rare ones more often, and weights (n,) as if all were drawn uniformly.

    The method is importance sampling: probabilities stay unbiased, and rare steps occur often.
    """
    shares = [(data.changes, CHANGES), (data.flagged, FLAGGED), (data.declined, DECLINED)]
    shares = [(pool, share) for pool, share in shares if len(pool)]
    alike = 1.0 - sum(share for _, share in shares)
    parts = [pool[_sample(len(pool), round(share * n), chance)] for pool, share in shares]
    at = torch.cat([*parts, _sample(len(data), n - sum(map(len, parts)), chance)])
    times = torch.full((n,), alike)  # how often a step is drawn, relative to uniform drawing
    for pool, share in shares:
        times += share * len(data) / len(pool) * torch.isin(at, pool)
    return at, 1.0 / times


def _sample(among: int, n: int, chance: torch.Generator) -> Tensor:
    return torch.randint(among, (n,), generator=chance)


def _with_wrong_words(moments: Moments, chance: torch.Generator) -> Moments:
    """Return moments with a wrong task in some, and no task in others.

    The network then relies more on observations.
    """
    n = len(moments.task)
    draw = torch.rand(n, generator=chance)
    other = torch.randint(N_TASKS, (n, 1), generator=chance).expand_as(moments.task)
    since_s = VERY_LONG_S * torch.rand(n, 1, generator=chance).expand_as(moments.since_s)
    misled, untold = (draw < MISLED)[:, None], (draw > 1.0 - UNTOLD)[:, None]
    task = torch.where(misled, other, moments.task)
    return moments._replace(
        task=torch.where(untold, N_TASKS, task),
        correction=torch.where(misled | untold, N_CORRECTIONS, moments.correction),
        since_s=torch.where(untold, 0.0, torch.where(misled, since_s, moments.since_s)),
        tries=torch.where(untold, 0, torch.where(misled, 1, moments.tries)),
    )


def with_many_tries(moments: Moments, chance: torch.Generator) -> tuple[Moments, Tensor]:
    """Return moments in some of which a clip or a cut was given too often, and (B,) in which.

    Few episodes come so far, and the oracle calls a person in each (`planner.scripted`).
    """
    deeds = torch.tensor([task.is_deed for task in TASKS] + [False])
    draw = torch.rand(len(moments.task), generator=chance) < TRIED_OUT
    tried_out = draw & deeds[moments.task[:, -1]]
    same = moments.task == moments.task[:, -1:]
    too_often = torch.where(same, MOST_TRIES + 1, moments.tries)
    return moments._replace(
        tries=torch.where(tried_out[:, None], too_often, moments.tries)
    ), tried_out


def loss_of(prediction: Prediction, labels: Labels, weight: Tensor) -> Tensor:
    """Return SRT-H's loss: the further off a task is, the larger its weight (arXiv 2505.10251).

    Weights (B,) correct the probabilities for the steps that were drawn more often.
    """
    off = (prediction.task.argmax(dim=-1) - labels.task).abs()
    task = (F.cross_entropy(prediction.task, labels.task, reduction="none") * (1 + off)).mean()
    flag = _chance_loss(prediction.flag, (labels.correction >= 0).float(), weight)
    progress = F.smooth_l1_loss(prediction.progress, labels.progress, beta=0.1)
    told = weight * ~labels.fails.isnan()
    fails = _chance_loss(prediction.fails, labels.fails.nan_to_num(), told)
    calls = _chance_loss(prediction.calls, labels.calls, weight)
    wanted = labels.correction.clamp(min=0)
    right = F.cross_entropy(prediction.correction, wanted, reduction="none")
    flagged = labels.correction >= 0
    correction = (right * flagged).sum() / flagged.sum().clamp(min=1)
    rest = (
        FLAG_WEIGHT * flag
        + CORRECTION_WEIGHT * correction
        + PROGRESS_WEIGHT * progress
        + FAILS_WEIGHT * fails
        + CALLS_WEIGHT * calls
    )
    return TASK_SHARE * task + (1.0 - TASK_SHARE) * rest


def _chance_loss(logits: Tensor, outcomes: Tensor, weight: Tensor) -> Tensor:
    loss = F.binary_cross_entropy_with_logits(logits, outcomes, weight, reduction="sum")
    return loss / weight.sum().clamp(min=MIN_WEIGHT)
