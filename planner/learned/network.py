"""The network: moments in, and out what to say, whether to correct, and how the task goes."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor, nn

from planner.learned.config import PlannerConfig
from planner.learned.features import N_CORRECTIONS, N_TASKS, seen_features, time_features
from tissue_sim.sensing.observation import VECTOR_SIZE

MIN_DEVIATION = 1e-3  # of a feature: what hardly varies is not blown up
MAX_DEVIATIONS = 6.0  # what lies further out than anything seen is taken to lie here


class Moments(NamedTuple):
    """What the planner has to go by: B times H moments, the newest last.

    Attributes:
        frames: (B, H, `VECTOR_SIZE`) `Observation.vector()`.
        known: (B, H) false before the episode began.
        task: (B, H) the task said last before each, 0 to 16; 17 where nothing was.
        correction: (B, H) likewise, 0 to 17; 18 where none was.
        since_s: (B, H) how long that task had been under way.
    """

    frames: Tensor
    known: Tensor
    task: Tensor
    correction: Tensor
    since_s: Tensor


class Opinion(NamedTuple):
    """Logits, but for the progress.

    Attributes:
        task: (B, 17) what should be under way now.
        flag: (B,) whether to correct.
        correction: (B, 18) what to say if so.
        progress: (B,) of that task, 0 to 1.
        fails: (B,) whether it will not be done in time.
    """

    task: Tensor
    flag: Tensor
    correction: Tensor
    progress: Tensor
    fails: Tensor


class PlannerNetwork(nn.Module):
    """A transformer over moments; its normalisation and calibration belong to its state.

    Attributes:
        calibration: (2,) scale and shift of the logit `fails`, so that it is a chance.
        alarm: () chance of failure above which a person should look.
    """

    mean: Tensor
    deviation: Tensor
    calibration: Tensor
    alarm: Tensor

    def __init__(self, config: PlannerConfig) -> None:
        super().__init__()
        self.config = config
        n = seen_features(torch.zeros(1, VECTOR_SIZE)).shape[1]
        self.register_buffer("mean", torch.zeros(n))
        self.register_buffer("deviation", torch.ones(n))
        self.register_buffer("calibration", torch.tensor([1.0, 0.0]))
        self.register_buffer("alarm", torch.tensor(1.0))
        self.enter = nn.Sequential(
            nn.Linear(n + 3, config.width), nn.SiLU(), nn.Linear(config.width, config.width)
        )
        self.task = nn.Embedding(N_TASKS + 1, config.width)
        self.correction = nn.Embedding(N_CORRECTIONS + 1, config.width)
        self.place = nn.Parameter(torch.zeros(config.history, config.width))
        layer = nn.TransformerEncoderLayer(
            config.width,
            config.heads,
            2 * config.width,
            dropout=0.0,  # its chance would not be resumed; moments are noised instead
            activation="gelu",
            batch_first=True,
            norm_first=True,
        )
        self.layers = nn.TransformerEncoder(layer, config.layers, enable_nested_tensor=False)
        self.leave = nn.Sequential(
            nn.LayerNorm(config.width), nn.Linear(config.width, N_TASKS + N_CORRECTIONS + 3)
        )

    def normalise_by(self, frames: Tensor) -> None:
        """Take mean and deviation of what is seen from many frames (n, `VECTOR_SIZE`)."""
        features = seen_features(frames)
        self.mean.copy_(features.mean(dim=0))
        self.deviation.copy_(features.std(dim=0).clamp(min=MIN_DEVIATION))

    def forward(self, moments: Moments) -> Opinion:
        """What to make of them."""
        seen = seen_features(moments.frames.flatten(0, 1)).unflatten(0, moments.known.shape)
        seen = ((seen - self.mean) / self.deviation).clamp(-MAX_DEVIATIONS, MAX_DEVIATIONS)
        tokens = self.enter(torch.cat([seen, time_features(moments.since_s)], dim=-1))
        tokens = tokens + self.task(moments.task) + self.correction(moments.correction) + self.place
        newest = self.layers(tokens, src_key_padding_mask=~moments.known)[:, -1]
        task, correction, rest = self.leave(newest).split([N_TASKS, N_CORRECTIONS, 3], dim=-1)
        return Opinion(task, rest[:, 0], correction, rest[:, 1].sigmoid(), rest[:, 2])

    def failure_chance(self, opinion: Opinion) -> Tensor:
        """Calibrated (B,)."""
        scale, shift = self.calibration
        return (scale * opinion.fails + shift).sigmoid()
