"""Encode the places of features in pictures, by a small convolutional network for each camera."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from planner.learning.networks import convolution


class CameraEncoder(nn.Module):
    """Encodes the place of each channel's feature in a picture, and its clarity.

    The encoder is the spatial softmax of Levine et al., "End-to-end training of deep visuomotor
    policies" (arXiv 1504.00702), with each channel's greatest value beside it.
    """

    def __init__(self, widths: Sequence[int]) -> None:
        super().__init__()
        a, b, c, d = widths
        self.layers = nn.Sequential(
            convolution(3, a, 2), convolution(a, b, 2), convolution(b, c, 2), convolution(c, d, 1),
            nn.Conv2d(d, d, 1),
        )  # fmt: skip

    def forward(self, pictures: Tensor) -> Tensor:
        """Return (B, 3 d): columns and rows, -1 to 1, and greatest values of d channels.

        Args:
            pictures: (B, 3, height, width) pictures, 0 to 1.
        """
        maps = self.layers((pictures - 0.4) / 0.25).float()
        share = maps.flatten(2).softmax(-1)
        rows, columns = (torch.linspace(-1.0, 1.0, n, device=maps.device) for n in maps.shape[-2:])
        places = torch.stack(torch.meshgrid(rows, columns, indexing="ij"), dim=-1).view(-1, 2)
        return torch.cat([(share @ places).flatten(1), maps.amax((2, 3))], dim=1)


class PictureEncoder(nn.Module):
    """An encoder for each camera."""

    def __init__(self, n_cameras: int, widths: Sequence[int]) -> None:
        super().__init__()
        self.each = nn.ModuleList(CameraEncoder(widths) for _ in range(n_cameras))
        self.size = n_cameras * 3 * widths[-1]

    def forward(self, pictures: Tensor) -> Tensor:
        """Return the codes (B, size) of pictures (B, cameras, 3, height, width), 0 to 1."""
        return torch.cat([encode(pictures[:, k]) for k, encode in enumerate(self.each)], dim=1)
