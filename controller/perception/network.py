"""Define the network that finds structures in a picture: a small U-Net, one for each view.

Points of the lines (tubes with both ends, gallbladder, structures at risk) have a heatmap each.
Clips and ends of cuts come in any number. All clips share a map of evidence, and so do all ends.
The cells of these maps also give the distance of the next clip or end.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional as F

from planner.learning.networks import Channels, convolution
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.sensing.observation import N_LINE, ROWS

N_WIDE = ROWS["sac_m"].stop  # of them, the first, are of tubes and gallbladder
DENSE = ("clip", "cut end")
FLAGS = (*(f"{tube} tube severed" for tube in TUBES), "third tube")
STRIDE = 4  # pixels of a map's cell
LOG_SIGMA = (-2.0, 4.0)  # limits, of pixels


@dataclass(frozen=True, kw_only=True)
class NetworkConfig:
    """Widths of the features at 1/2, 1/4, 1/8, 1/16 and 1/32 of the picture's size."""

    widths: tuple[Channels, Channels, Channels, Channels, Channels] = (16, 32, 64, 96, 96)
    maps: Channels = 48


@dataclass(frozen=True)
class Seen:
    """The output of a network for pictures (b, 3, height, width).

    Attributes:
        heat: (b, `N_LINE`, h, w) log probability of each point's place, not normalised.
        pixels: (b, `N_LINE`, 2) mean column and row of the heatmaps.
        log_sigma: (b, `N_LINE`) logarithm of the expected distance from the true pixel, pixels.
        inside: (b, `N_LINE`) logit that the picture's frame holds the point.
        visible: (b, `N_LINE`) logit that nothing hides it.
        log_radius: (b, `N_LINE`) logarithm of the structure's apparent radius, pixels.
        dense: (b, 2, h, w) logits of `DENSE`.
        offset: (b, 2, 2, h, w) column and row of the nearest clip and end from a cell's middle,
            pixels. The offset is valid near a clip or an end only.
        flags: (b, 4) logits of `FLAGS`.
    """

    heat: Tensor
    pixels: Tensor
    log_sigma: Tensor
    inside: Tensor
    visible: Tensor
    log_radius: Tensor
    dense: Tensor
    offset: Tensor
    flags: Tensor


class Network(nn.Module):
    """The U-Net of one view."""

    def __init__(self, config: NetworkConfig) -> None:
        super().__init__()
        a, b, c, d, e = config.widths
        self.down = nn.ModuleList(
            [
                nn.Sequential(convolution(3, a, 2), convolution(a, b, 2), convolution(b, b)),
                nn.Sequential(convolution(b, c, 2), convolution(c, c)),
                nn.Sequential(convolution(c, d, 2), convolution(d, d), convolution(d, d)),
                nn.Sequential(convolution(d, e, 2), convolution(e, e)),
            ]
        )
        self.rise = nn.ModuleList(
            [nn.Conv2d(e, d, 1), nn.Conv2d(d, c, 1), nn.Conv2d(c, config.maps, 1)]
        )
        self.skip = nn.Conv2d(b, config.maps, 1)
        self.mix = nn.ModuleList(
            [
                convolution(d, d),
                convolution(c, c),
                nn.Sequential(
                    convolution(config.maps, config.maps), convolution(config.maps, config.maps)
                ),
            ]
        )
        self.head = nn.Conv2d(config.maps, N_LINE + len(DENSE), 1)
        self.offset = nn.Conv2d(config.maps, 2 * len(DENSE), 1)
        self.who = nn.Parameter(0.1 * torch.randn(N_LINE, 32))
        self.about = nn.Sequential(nn.Linear(config.maps + e + 32, 64), nn.ReLU(), nn.Linear(64, 4))
        self.flags = nn.Sequential(nn.Linear(2 * e, 64), nn.ReLU(), nn.Linear(64, len(FLAGS)))

    def forward(self, pictures: Tensor) -> Seen:
        """Return the network's output for pictures (b, 3, height, width), 0 to 1."""
        levels = [(pictures - 0.4) / 0.25]
        for down in self.down:
            levels.append(down(levels[-1]))
        _, fine, *middle, last = levels
        x = last
        for rise, mix, beside in zip(
            self.rise, self.mix, (middle[1], middle[0], self.skip(fine)), strict=True
        ):
            x = mix(beside + F.interpolate(rise(x), beside.shape[-2:], mode="nearest"))
        maps, whole = self.head(x).float(), last.mean((2, 3)).float()
        strongest = last.amax((2, 3)).float()  # a thin tube is lost in a mean
        heat, dense = maps[:, :N_LINE], maps[:, N_LINE:]
        share = heat.flatten(2).softmax(-1)
        about = self._about(share, x.float(), whole)
        return Seen(
            heat=heat,
            pixels=_mean_pixels(share, heat),
            log_sigma=about[..., 0].clamp(*LOG_SIGMA),
            inside=about[..., 1],
            visible=about[..., 2],
            log_radius=about[..., 3],
            dense=dense,
            offset=STRIDE * self.offset(x).float().unflatten(1, (len(DENSE), 2)),
            flags=self.flags(torch.cat([whole, strongest], dim=1)),
        )

    def _about(self, share: Tensor, features: Tensor, whole: Tensor) -> Tensor:
        """Return four numbers per point (b, `N_LINE`, 4), from the features at the point."""
        there = share @ features.flatten(2).transpose(1, 2)
        n = len(there)
        parts = (there, whole[:, None].expand(n, N_LINE, -1), self.who.expand(n, -1, -1))
        return self.about(torch.cat(parts, dim=-1).float())


def axes(maps: Tensor) -> tuple[Tensor, Tensor]:
    """Return the columns (w,) and rows (h,) of the middles of maps' cells, pixels."""
    h, w = maps.shape[-2:]
    column = STRIDE * (torch.arange(w, device=maps.device) + 0.5)
    return column, STRIDE * (torch.arange(h, device=maps.device) + 0.5)


def _mean_pixels(share: Tensor, heat: Tensor) -> Tensor:
    """Return the mean column and row (b, n, 2) of heatmaps with these shares (b, n, h * w)."""
    column, row = axes(heat)
    places = torch.stack([column.repeat(len(row)), row.repeat_interleave(len(column))], dim=1)
    return share @ places
