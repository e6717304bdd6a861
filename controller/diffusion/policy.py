"""The diffusion policy: its loss, and its sampler."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW
from controller.diffusion.config import PolicyConfig
from controller.diffusion.denoiser import ConditionEncoder, Denoiser
from controller.diffusion.features import Features
from tissue_sim.observation import VECTOR_SIZE

LEAST_DEVIATION = 1e-3  # of a feature or of a chunk's entry: what hardly varies is not blown up
MOST_DEVIATIONS = 6.0  # what lies further out than anything seen is taken to lie here


class Policy(nn.Module):
    """Chunks given what is seen and said. Its normalisation belongs to its state.

    Within, jaws are relative to those commanded last: an arm that is to hold then keeps its grip,
    where a prediction of the opening itself would drift a little with each chunk.
    """

    feature_mean: Tensor
    feature_deviation: Tensor
    chunk_mean: Tensor
    chunk_deviation: Tensor

    def __init__(self, config: PolicyConfig) -> None:
        super().__init__()
        self.config = config
        self.features = Features()
        frames = torch.zeros(1, len(config.history), VECTOR_SIZE)
        n = self.features(frames, torch.zeros(1, 2)).shape[1]
        shape = (config.horizon, ACTION_SIZE)
        self.register_buffer("feature_mean", torch.zeros(n))
        self.register_buffer("feature_deviation", torch.ones(n))
        self.register_buffer("chunk_mean", torch.zeros(shape))
        self.register_buffer("chunk_deviation", torch.ones(shape))
        self.encoder = ConditionEncoder(n, config)
        self.denoiser = Denoiser(config)

    def normalise_by(self, history: Tensor, jaw_rad: Tensor, chunk: Tensor) -> None:
        """Take mean and deviation of what is seen and of chunks from many windows."""
        features = self.features(history, jaw_rad)
        self.feature_mean.copy_(features.mean(dim=0))
        self.feature_deviation.copy_(features.std(dim=0).clamp(min=LEAST_DEVIATION))
        change = chunk - _held(jaw_rad)
        self.chunk_mean.copy_(change.mean(dim=0))
        self.chunk_deviation.copy_(change.std(dim=0).clamp(min=LEAST_DEVIATION))

    def condition(self, history: Tensor, jaw_rad: Tensor, words: Tensor) -> Tensor:
        """(B, width) of frames (B, K, `VECTOR_SIZE`), jaws (B, 2) and embeddings (B, 384)."""
        features = (self.features(history, jaw_rad) - self.feature_mean) / self.feature_deviation
        return self.encoder(features.clamp(-MOST_DEVIATIONS, MOST_DEVIATIONS), words)

    def loss(
        self,
        condition: Tensor,
        jaw_rad: Tensor,
        chunk: Tensor,
        valid: Tensor,
        n_committed: Tensor,
        level: Tensor,
        noise: Tensor,
    ) -> Tensor:
        """Mean squared error of the clean chunk, over valid rows that are not committed.

        Args:
            condition: (B, width).
            jaw_rad: (B, 2) commanded last.
            chunk: (B, H, 20).
            valid: (B, H).
            n_committed: (B, M) rows given clean.
            level: (B, M).
            noise: (B, M, H, 20) standard normal.
        """
        clean = self._normal(chunk, jaw_rad)[:, None]
        committed = self._committed_rows(n_committed)
        noisy = _mixed(clean, noise, level[..., None, None])
        guess = self._denoise(noisy, clean, committed, level, condition)
        counts = (valid[:, None].to(committed) * (1.0 - committed))[..., None]
        return (counts * (guess - clean) ** 2).sum() / (ACTION_SIZE * counts.sum().clamp(min=1.0))

    def forward(
        self,
        history: Tensor,
        jaw_rad: Tensor,
        words: Tensor,
        committed_chunk: Tensor,
        n_committed: Tensor,
        noise: Tensor,
    ) -> Tensor:
        """Sample chunks (B, H, 20), without chance: all noise is given.

        DDIM (Song et al., arXiv 2010.02502) in `config.sampling_steps` equal steps.

        Args:
            history: (B, K, `VECTOR_SIZE`) frames seen.
            jaw_rad: (B, 2) commanded last.
            words: (B, 384) the embedding of what is said.
            committed_chunk: (B, H, 20) whose first rows will be played in any case.
            n_committed: (B,) how many.
            noise: (B, H, 20) standard normal.
        """
        condition = self.condition(history, jaw_rad, words)
        given = self._normal(committed_chunk, jaw_rad)[:, None]
        committed = self._committed_rows(n_committed[:, None])
        steps, noisy = self.config.sampling_steps, noise[:, None]
        clean = noisy
        for k in range(steps, 0, -1):
            level, lower = k / steps, (k - 1) / steps
            at = torch.full_like(n_committed[:, None], level, dtype=noise.dtype)
            clean = self._denoise(noisy, given, committed, at, condition)
            signal, share = _signal(level), _noise(level)
            noisy = _signal(lower) * clean + _noise(lower) * (noisy - signal * clean) / share
        rows = committed[..., None]
        clean = rows * given + (1.0 - rows) * clean
        return clean[:, 0] * self.chunk_deviation + self.chunk_mean + _held(jaw_rad)

    def _normal(self, chunk: Tensor, jaw_rad: Tensor) -> Tensor:
        return (chunk - _held(jaw_rad) - self.chunk_mean) / self.chunk_deviation

    def _committed_rows(self, n_committed: Tensor) -> Tensor:
        rows = torch.arange(self.config.horizon, device=n_committed.device)
        return (rows < n_committed[..., None]).to(self.chunk_mean.dtype)

    def _denoise(
        self, noisy: Tensor, given: Tensor, committed: Tensor, level: Tensor, condition: Tensor
    ) -> Tensor:
        rows = committed[..., None]
        return self.denoiser(rows * given + (1.0 - rows) * noisy, committed, level, condition)


def _held(jaw_rad: Tensor) -> Tensor:
    """(B, 1, 20) that is the jaws (B, 2) where a chunk has its jaws, and else zero."""
    arms = torch.cat([jaw_rad.new_zeros(len(jaw_rad), 2, JAW), jaw_rad[..., None]], dim=-1)
    return arms.flatten(1)[:, None]


def _signal(level: float) -> float:
    return math.cos(0.5 * math.pi * level)


def _noise(level: float) -> float:
    return math.sin(0.5 * math.pi * level)


def _mixed(clean: Tensor, noise: Tensor, level: Tensor) -> Tensor:
    """Variance-preserving, on a cosine schedule."""
    angle = 0.5 * math.pi * level
    return angle.cos() * clean + angle.sin() * noise
