"""Diffuse chunks under features and a command: the loss and sampler, for features of any kind."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from controller.action import ACTION_SIZE
from controller.diffusion.chunk_frame import JAW
from controller.diffusion.command import NONE, tokens
from controller.diffusion.config import PolicyConfig
from controller.diffusion.denoiser import ConditionEncoder, Denoiser
from controller.diffusion.windows import Batch
from planner.learning.networks import MAX_DEVIATIONS, MIN_DEVIATION

FINE = 4.0  # weight of a tool's motion near tissue, before it touches: there tenths of a mm count


class ChunkDiffusion(nn.Module):
    """Samples chunks from features and a command; the normalisation belongs to the state.

    Internally, jaw angles are relative to the last commanded ones, so that an arm that holds keeps
    its grip. A prediction of the opening itself would drift a little with each chunk.
    """

    feature_mean: Tensor
    feature_deviation: Tensor
    past_mean: Tensor
    past_deviation: Tensor
    chunk_mean: Tensor
    chunk_deviation: Tensor

    def __init__(self, config: PolicyConfig, n_features: int) -> None:
        super().__init__()
        self.config = config
        past, shape = (config.past, ACTION_SIZE), (config.horizon, ACTION_SIZE)
        self.register_buffer("feature_mean", torch.zeros(n_features))
        self.register_buffer("feature_deviation", torch.ones(n_features))
        self.register_buffer("past_mean", torch.zeros(past))
        self.register_buffer("past_deviation", torch.ones(past))
        self.register_buffer("chunk_mean", torch.zeros(shape))
        self.register_buffer("chunk_deviation", torch.ones(shape))
        self.encoder = ConditionEncoder(n_features, config)
        self.denoiser = Denoiser(config)

    def normalise_by(self, features: Tensor, seen: Batch) -> None:
        """Set mean and deviation of features (B, n), pasts and chunks from many windows."""
        for name, values in (
            ("feature", features),
            ("past", seen.past - _held(seen.jaw_rad)),
            ("chunk", seen.chunk - _held(seen.jaw_rad)),
        ):
            getattr(self, f"{name}_mean").copy_(values.mean(dim=0))
            getattr(self, f"{name}_deviation").copy_(values.std(dim=0).clamp(min=MIN_DEVIATION))

    def loss(
        self,
        features: Tensor,
        seen: Batch,
        said: Sequence[Tensor],
        kept: Tensor,
        level: Tensor,
        noise: Tensor,
    ) -> Tensor:
        """Return the mean squared error of the clean chunk, over valid rows.

        Motions of a tool near tissue that does not touch it yet weigh `FINE` times as much.

        Args:
            features: (B, n) features of the windows.
            seen: The B windows.
            said: Embeddings of the tasks and of the corrections, from `command.sentences`. The
                network encodes each sentence once, not each window.
            kept: (B, 1) 1, or 0 for windows whose command is dropped.
            level: (B, M) noise levels.
            noise: (B, M, H, 20) standard normal noise.
        """
        held = _held(seen.jaw_rad)
        clean = ((seen.chunk - held - self.chunk_mean) / self.chunk_deviation)[:, None]
        past = self._given(seen.past - held, seen.n_past)
        tasks, corrections = (
            self.encoder.task_words(said[0]),
            self.encoder.correction_words(said[1]),
        )
        words = F.embedding(seen.task, tasks) + F.embedding(seen.correction - NONE, corrections)
        token = tokens(seen.task, seen.correction, seen.left)
        command = self.encoder.command(kept * words, kept * token)
        condition = self._condition(features, command, past, seen.delay)
        guess = self.denoiser(_mixed(clean, noise, level[..., None, None]), past, level, condition)
        weight = 1.0 + (FINE - 1.0) * (seen.near & seen.free).to(guess)  # (B, 2)
        of_arms = weight.repeat_interleave(ACTION_SIZE // 2, dim=1)[:, None, None]
        counts = (seen.valid[:, None, :, None].to(guess) * of_arms).expand_as(guess)
        return (counts * (guess - clean) ** 2).sum() / counts.sum()

    def sample(
        self,
        features: Tensor,
        jaw_rad: Tensor,
        words: Tensor,
        token: Tensor,
        past: Tensor,
        n_past: Tensor,
        delay: Tensor,
        noise: Tensor,
    ) -> Tensor:
        """Sample chunks (B, H, 20) deterministically, because all noise is an input.

        The sampler is DDIM (Song et al., arXiv 2010.02502) in `config.sampling_steps` equal steps.

        Args:
            features: (B, n) features.
            jaw_rad: (B, 2) jaws last commanded before the chunk.
            words: (B, 2, 384) embeddings of the task, and of the correction (zeros if none).
            token: (B, `TOKEN_SIZE`) the command in numbers.
            past: (B, P, 20) rows before the chunk.
            n_past: (B,) number of known rows of the past, which are the last ones.
            delay: (B,) number of rows of the past that come after the newest frame.
            noise: (B, H, 20) standard normal noise.
        """
        held = _held(jaw_rad)
        given = self._given(past - held, n_past)
        both = self.encoder.task_words(words[:, 0]) + self.encoder.correction_words(words[:, 1])
        command = self.encoder.command(both, token)
        condition = self._condition(features, command, given, delay)
        steps, noisy, guidance = self.config.sampling_steps, noise[:, None], self.config.guidance
        if guidance:
            without = self.encoder.command(torch.zeros_like(both), torch.zeros_like(token))
            uncommanded = self._condition(features, without, given, delay)
        clean = noisy
        for k in range(steps, 0, -1):
            level, lower = k / steps, (k - 1) / steps
            at = torch.full_like(n_past[:, None], level, dtype=noise.dtype)
            clean = self.denoiser(noisy, given, at, condition)
            if guidance:
                clean = clean + guidance * (clean - self.denoiser(noisy, given, at, uncommanded))
            signal, share = _signal(level), _noise(level)
            noisy = _signal(lower) * clean + _noise(lower) * (noisy - signal * clean) / share
        return clean[:, 0] * self.chunk_deviation + self.chunk_mean + held

    def _condition(self, features: Tensor, command: Tensor, past: Tensor, delay: Tensor) -> Tensor:
        normal = (features - self.feature_mean) / self.feature_deviation
        delays = torch.arange(self.config.max_delay + 1, device=delay.device)
        marked = (delays == delay[:, None]).to(normal)
        return self.encoder(normal.clamp(-MAX_DEVIATIONS, MAX_DEVIATIONS), past, marked, command)

    def _given(self, past: Tensor, n_past: Tensor) -> Tensor:
        """Return (B, P * 21): the past normalised, zero where unknown, and which rows are known."""
        rows = torch.arange(self.config.past, 0, -1, device=n_past.device)
        known = (rows <= n_past[:, None]).to(past)
        normal = known[..., None] * (past - self.past_mean) / self.past_deviation
        return torch.cat([normal.flatten(1), known], dim=1)


def _held(jaw_rad: Tensor) -> Tensor:
    """Return (B, 1, 20) with the jaws (B, 2) in a chunk's jaw entries, zero elsewhere."""
    arms = torch.cat([jaw_rad.new_zeros(len(jaw_rad), 2, JAW), jaw_rad[..., None]], dim=-1)
    return arms.flatten(1)[:, None]


def _signal(level: float) -> float:
    return math.cos(0.5 * math.pi * level)


def _noise(level: float) -> float:
    return math.sin(0.5 * math.pi * level)


def _mixed(clean: Tensor, noise: Tensor, level: Tensor) -> Tensor:
    """Mix clean chunks and noise: variance-preserving, on a cosine schedule."""
    angle = 0.5 * math.pi * level
    return angle.cos() * clean + angle.sin() * noise
