"""Spoil a camera's picture with smoke, blood on the lens, a weak lamp, or a dead camera.

Pictures are batches (n, 3, height, width), 0 to 1. They are for the training of perception and for
scenarios. The looks of smoke and blood are assumed.
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional as F

GREY = 0.75  # of smoke
BLOOD = (0.35, 0.03, 0.02)
PATCHES = 5  # coarse cells along each side of the picture
SOFT = 0.05  # of a patch's edge


def smoked(pictures: Tensor, density: Tensor, chance: torch.Generator) -> Tensor:
    """Return pictures behind smoke, whose density varies over the picture.

    Args:
        pictures: (n, 3, height, width).
        density: (n,) share of the light that smoke takes, on average over the picture.
        chance: random numbers.
    """
    thick = 1.0 + 0.3 * _patches(pictures, chance).tanh()
    share = (density[:, None, None, None] * thick).clamp(0.0, 1.0)
    return (1.0 - share) * pictures + share * GREY


def splashed(pictures: Tensor, share: Tensor, chance: torch.Generator) -> tuple[Tensor, Tensor]:
    """Return pictures through a lens with patches of blood, and the places of the patches.

    Args:
        pictures: (n, 3, height, width).
        share: (n,) covered share of the picture.
        chance: random numbers.

    Returns:
        Pictures, and the patches' opacity (n, 1, height, width).
    """
    field, some = _patches(pictures, chance), share > 0.0
    ranked = field[some].flatten(1).sort(dim=1).values
    last = ranked.shape[1] - 1
    edge = field.new_full((len(field), 1), torch.inf)
    edge[some] = ranked.gather(1, ((1.0 - share[some]) * last).long()[:, None])
    cover = ((field - edge[:, :, None, None]) / SOFT).sigmoid()
    blood = pictures.new_tensor(BLOOD)[None, :, None, None]
    return (1.0 - cover) * pictures + cover * blood, cover


def dimmed(pictures: Tensor, share: Tensor) -> Tensor:
    """Return pictures under a lamp that lacks a share (n,) of its light."""
    return (1.0 - share)[:, None, None, None] * pictures


def _patches(pictures: Tensor, chance: torch.Generator) -> Tensor:
    """Return a smooth random field (n, 1, height, width)."""
    coarse = torch.randn(
        len(pictures), 1, PATCHES, PATCHES, generator=chance, device=pictures.device
    )
    return F.interpolate(coarse, pictures.shape[-2:], mode="bicubic", align_corners=False)
