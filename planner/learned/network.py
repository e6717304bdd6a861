"""Define the learned planner's network, its configuration and its checkpoints.

The network goes from moments to a task, a correction, progress, the risk of failure and a call.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import torch
from torch import Tensor, nn

from planner.correction import CORRECTIONS
from planner.learned.features import N_CORRECTIONS, N_TASKS, seen_features, time_features
from planner.learning.checkpoint import Checkpoints
from planner.learning.networks import MAX_DEVIATIONS, MIN_DEVIATION, Layers, SomeSteps, Width
from planner.procedure.cholecystectomy import TASKS
from tissue_sim.constants import WORLD_VERSION
from tissue_sim.sensing.observation import VECTOR_SIZE

MOST_TOLD = 4  # tries that are told apart; more count as these
REST = 4  # outputs besides tasks and corrections: flag, progress, failure and call


@dataclass(frozen=True, kw_only=True)
class PlannerConfig:
    """Shapes of the network.

    Attributes:
        history: Number of moments, one per request to the planner, with the present one.
        width, layers, heads: Sizes of the transformer over the moments.

    Raises:
        ValueError: The heads do not divide the width.
    """

    history: SomeSteps = 8
    width: Width = 256
    layers: Layers = 3
    heads: Width = 4

    def __post_init__(self) -> None:
        if self.width % self.heads:
            raise ValueError(f"heads must divide width, got {self.heads} of {self.width}")


class Moments(NamedTuple):
    """The network's input: B times H moments, the newest last.

    Attributes:
        frames: (B, H, `VECTOR_SIZE`) observations, as `Observation.vector()`.
        known: (B, H) false before the episode began.
        task: (B, H) the last task given before each moment, 0 to 24; 25 if there was none.
        correction: (B, H) the last correction given, 0 to 17; 18 if there was none.
        since_s: (B, H) time since that task was given.
        tries: (B, H) how many times that task had been given; 0 if there was none.
    """

    frames: Tensor
    known: Tensor
    task: Tensor
    correction: Tensor
    since_s: Tensor
    tries: Tensor


class Prediction(NamedTuple):
    """The network's output: logits, except for the progress.

    Attributes:
        task: (B, 25) the task that should be given now.
        flag: (B,) whether a correction is needed.
        correction: (B, 18) the correction, if any.
        progress: (B,) progress of the task, 0 to 1.
        fails: (B,) whether the task will not be done in time.
        calls: (B,) whether a person must be called.
    """

    task: Tensor
    flag: Tensor
    correction: Tensor
    progress: Tensor
    fails: Tensor
    calls: Tensor


class PlannerNetwork(nn.Module):
    """A transformer over moments; its normalisation and calibration belong to its state.

    Attributes:
        calibration: (2,) scale and shift that make the logit `fails` a probability.
        alarm: () probability of failure above which a person should look.
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
            nn.Linear(n + 3, config.width),
            nn.SiLU(),
            nn.Linear(config.width, config.width),
        )
        self.task = nn.Embedding(N_TASKS + 1, config.width)
        self.correction = nn.Embedding(N_CORRECTIONS + 1, config.width)
        self.tries = nn.Embedding(MOST_TOLD + 1, config.width)
        self.place = nn.Parameter(torch.zeros(config.history, config.width))
        layer = nn.TransformerEncoderLayer(
            config.width,
            config.heads,
            2 * config.width,
            dropout=0.0,  # its random state could not be resumed
            activation="gelu",
            batch_first=True,
            norm_first=True,
        )
        self.layers = nn.TransformerEncoder(layer, config.layers, enable_nested_tensor=False)
        self.leave = nn.Sequential(
            nn.LayerNorm(config.width), nn.Linear(config.width, N_TASKS + N_CORRECTIONS + REST)
        )

    def normalise_by(self, frames: Tensor) -> None:
        """Set mean and deviation of the features from many frames (n, `VECTOR_SIZE`)."""
        features = seen_features(frames)
        self.mean.copy_(features.mean(dim=0))
        self.deviation.copy_(features.std(dim=0).clamp(min=MIN_DEVIATION))

    def forward(self, moments: Moments) -> Prediction:
        """Predict task, correction, progress, failure and call from the moments."""
        seen = seen_features(moments.frames.flatten(0, 1)).unflatten(0, moments.known.shape)
        seen = ((seen - self.mean) / self.deviation).clamp(-MAX_DEVIATIONS, MAX_DEVIATIONS)
        tokens = self.enter(torch.cat([seen, time_features(moments.since_s)], dim=-1))
        tokens = tokens + self.task(moments.task) + self.correction(moments.correction)
        tokens = tokens + self.tries(moments.tries.clamp(max=MOST_TOLD)) + self.place
        newest = self.layers(tokens, src_key_padding_mask=~moments.known)[:, -1]
        task, correction, rest = self.leave(newest).split([N_TASKS, N_CORRECTIONS, REST], dim=-1)
        flag, progress, fails, calls = rest.unbind(dim=1)
        return Prediction(task, flag, correction, progress.sigmoid(), fails, calls)

    def failure_chance(self, prediction: Prediction) -> Tensor:
        """Return the calibrated probability of failure (B,)."""
        scale, shift = self.calibration
        return (scale * prediction.fails + shift).sigmoid()


CHECKPOINTS = Checkpoints(
    learner="planner",
    holds="learned planner",
    shipped=Path(__file__).with_name("planner.safetensors"),
    fits={
        "world version": WORLD_VERSION,
        "schema": 6,
        "observation size": VECTOR_SIZE,
        "instructions": len(TASKS) + len(CORRECTIONS),
    },
    config_type=PlannerConfig,
    model_from=PlannerNetwork,
)
