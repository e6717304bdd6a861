"""Define the network, which denoises chunks under a condition of observation and words."""

from __future__ import annotations

import math
from typing import cast

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from controller.action import ACTION_SIZE
from controller.diffusion.command import TOKEN_SIZE
from controller.diffusion.config import WORDS_SIZE, PolicyConfig

LEVEL_WAVES = 16
TOKEN_WIDTH = 128


class FilmBlock(nn.Module):
    """A residual layer that a condition scales and shifts (Perez et al., arXiv 1709.07871)."""

    def __init__(self, width: int, condition: int) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(width, elementwise_affine=False)
        self.film = nn.Linear(condition, 2 * width)
        self.inner = nn.Linear(width, width)
        self.outer = nn.Linear(width, width)

    def forward(self, x: Tensor, film: Tensor) -> Tensor:
        """Transform x (B, ..., width) by scale and shift (B, ..., 2 width), broadcast."""
        scale, shift = film.chunk(2, dim=-1)
        modulated = self.norm(x) * (1.0 + scale) + shift
        return x + self.outer(F.silu(self.inner(modulated)))


class ConditionEncoder(nn.Module):
    """Encodes features under a command, which determines the features that matter."""

    def __init__(self, n_features: int, config: PolicyConfig) -> None:
        super().__init__()
        width = config.condition_width
        n_past, n_delays = config.past * (ACTION_SIZE + 1), config.max_delay + 1
        self.enter = nn.Linear(n_features + n_past + n_delays, width)
        self.task_words = nn.Linear(WORDS_SIZE, width, bias=False)
        self.correction_words = nn.Linear(WORDS_SIZE, width, bias=False)
        self.token = nn.Sequential(
            nn.Linear(TOKEN_SIZE, TOKEN_WIDTH, bias=False),
            nn.SiLU(),
            nn.Linear(TOKEN_WIDTH, width),
        )
        self.blocks = nn.ModuleList(FilmBlock(width, width) for _ in range(config.condition_blocks))

    def command(self, words: Tensor, token: Tensor) -> Tensor:
        """Return commands (B, width).

        Args:
            words: (B, width) sums of `task_words` and `correction_words` of the sentences.
            token: (B, `TOKEN_SIZE`) tokens. Zeros of both are no command.
        """
        return F.silu(words + self.token(token))

    def forward(self, features: Tensor, past: Tensor, delay: Tensor, command: Tensor) -> Tensor:
        """Return the condition (B, 2 width) of features `delay` motions before the chunk begins.

        The second half is the command itself.

        Args:
            features: (B, n) normalised features.
            past: The past, as in `Denoiser.forward`.
            delay: (B, max_delay + 1), 1 at the delay.
            command: (B, width) commands.
        """
        x = self.enter(torch.cat([features, past, delay], dim=-1))
        for block in self.blocks:
            x = block(x, cast(FilmBlock, block).film(command))
        return torch.cat([x, command], dim=-1)


class Denoiser(nn.Module):
    """Predicts the clean chunk from a noisy one and the clean motions before it, the past.

    The method is training-time real-time chunking (arXiv 2512.05964), with an MLP that predicts the
    clean chunk.
    """

    def __init__(self, config: PolicyConfig) -> None:
        super().__init__()
        width, size = config.denoiser_width, config.horizon * ACTION_SIZE
        past_size = config.past * (ACTION_SIZE + 1)
        self.enter = nn.Linear(size + past_size + 2 * LEVEL_WAVES, width)
        self.blocks = nn.ModuleList(
            FilmBlock(width, 2 * config.condition_width) for _ in range(config.denoiser_blocks)
        )
        self.norm = nn.LayerNorm(width)
        self.leave = nn.Linear(width, size)

    def forward(self, noisy: Tensor, past: Tensor, level: Tensor, condition: Tensor) -> Tensor:
        """Return clean chunks (B, M, H, 20) from M noisy ones for each of B conditions.

        Args:
            noisy: (B, M, H, 20) noisy chunks.
            past: (B, P * 21) rows before the chunk, and a mask of the known rows.
            level: (B, M) noise levels, from 0 (clean) to 1 (noise alone).
            condition: (B, 2 condition_width) conditions.
        """
        led = past[:, None].expand(-1, noisy.shape[1], -1)
        x = torch.cat([noisy.flatten(2), led, _waves(level)], dim=-1)
        x, condition = self.enter(x), condition[:, None]
        for block in self.blocks:
            x = block(x, cast(FilmBlock, block).film(condition))
        return self.leave(self.norm(x)).view(noisy.shape)


def _waves(level: Tensor) -> Tensor:
    rates = math.pi * 2.0 ** torch.linspace(-1.0, 5.0, LEVEL_WAVES, device=level.device)
    angles = level[..., None] * rates
    return torch.cat([angles.sin(), angles.cos()], dim=-1)
