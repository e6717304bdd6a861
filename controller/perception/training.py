"""Train a view's network; a stopped training resumes exactly."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import ClassVar

import torch
from torch import Tensor
from torch.nn import functional as F

from controller.perception.checkpoint import (
    CHECKPOINTS,
    PerceptionConfig,
    PerceptionModel,
)
from controller.perception.frames import Frames, changed, read_frames
from controller.perception.network import N_WIDE, Network, NetworkConfig, Seen, axes
from controller.perception.prior import fit_prior
from planner.learning.optimise import Schedule, TrainingStep, optimise
from tissue_sim.sensing.observation import N_LINE, N_POINTS

GROUPS = (slice(N_LINE, N_POINTS), slice(N_POINTS, None))  # of labelled points: clips, cut ends
VIEWS = ("endoscope_left", "endoscope_left_close", "wrist_left_tip", "wrist_right_tip")
WEIGHTS_FILE, CHECKPOINT_FILE = "view.pt", CHECKPOINTS.shipped.name
HEAT_PX = 4.0  # standard deviation of a heatmap's target
DENSE_PX = 3.0  # of the evidence's targets
NEXT_PX = 6.0  # distance from a clip or an end within which a cell should give its place
LEAST_PX = 0.1  # radius of a structure; smaller ones are not there
FOUND = 8.0  # weight of a cell that shows a clip or an end: they are few


@dataclass(frozen=True, kw_only=True)
class PerceptionTraining(Schedule):
    """The settings of the training of a view's network."""

    shape: ClassVar[str] = "network"
    shape_of: ClassVar[str] = "config.network"
    network: NetworkConfig = field(default_factory=NetworkConfig)
    steps: int = 12_000
    batch: int = 16
    learning_rate: float = 2e-3
    weight_decay: float = 1e-3
    warm_up: int = 50
    average: float = 0.99
    save_every: int = 200


PRESETS = {
    "full": PerceptionTraining(),
    "smoke": PerceptionTraining(
        network=NetworkConfig(widths=(8, 8, 8, 8, 8), maps=8),
        steps=4,
        batch=2,
        warm_up=1,
        average=0.5,
        save_every=2,
    ),
}


def train_view(
    files: Sequence[Path],
    view: str,
    config: PerceptionTraining,
    out: Path,
    device: str = "cpu",
    base: PerceptionModel | None = None,
) -> Iterator[TrainingStep]:
    """Train a view's network on labelled frames, or resume the training in `out`.

    Raises:
        ValueError: As in `optimise`, or as in `read_frames`.
    """
    start = None if base is None else base.networks[view]
    data = ViewData(read_frames(files, view), config, device)
    make, path = partial(_network, config.network), out / WEIGHTS_FILE
    return optimise(make, data, config, path, _save, device, start)


def _network(config: NetworkConfig) -> Network:
    return Network(config).to(memory_format=torch.channels_last)  # pyright: ignore


def _save(path: Path, network: Network) -> None:
    torch.save(network.state_dict(), path)


class ViewData:
    """The labelled frames of a view.

    Attributes:
        digest: Digest of all training data, in hex.
    """

    def __init__(self, frames: Frames, config: PerceptionTraining, device: str) -> None:
        self.digest, self._frames, self._config = frames.digest, frames.to(device), config

    def normalise(self, network: Network, chance: torch.Generator) -> None:
        """Do nothing: pictures need no normalisation."""

    def loss(self, network: Network, chance: torch.Generator) -> Tensor:
        """Return the loss of random frames, each changed at random."""
        shape, device = (self._config.batch,), chance.device
        which = torch.randint(len(self._frames), shape, generator=chance, device=device)
        pictures, labels = changed(self._frames.some(which), chance)
        pictures = pictures.contiguous(memory_format=torch.channels_last)
        with torch.autocast(device.type, torch.bfloat16, enabled=self._config.bfloat16):
            seen = network(pictures)
        return loss(seen, labels)


def join_views(
    files: Sequence[Path],
    config: PerceptionTraining,
    out: Path,
    base: PerceptionModel | None = None,
) -> Path:
    """Write the checkpoint of all trained views and of the prior; return its path.

    The prior is fitted to the files, but a fine-tuned perception keeps its own prior. A prior
    fitted to few further patients would be too certain.
    """
    sizes = {view: read_frames(files[:1], view).rgb.shape[2:0:-1] for view in VIEWS}
    perception = PerceptionConfig(
        views=VIEWS,
        sizes=tuple((width, height) for width, height in sizes.values()),
        network=config.network,
    )
    model = PerceptionModel(perception, base.prior() if base else fit_prior(files))
    for view, network in model.networks.items():
        network.load_state_dict(torch.load(out / view / WEIGHTS_FILE, weights_only=True))
    CHECKPOINTS.save(out / CHECKPOINT_FILE, model)
    return out / CHECKPOINT_FILE


def loss(seen: Seen, frames: Frames) -> Tensor:
    """Return the loss of a network's output for frames with these labels."""
    pixels, (height, width) = frames.pixels, frames.rgb.shape[1:3]
    size = torch.tensor([width, height], device=pixels.device)
    framed = frames.there & ((pixels > 0) & (pixels < size)).all(-1)
    lines, shown = framed[:, :N_LINE], frames.visible & framed
    weight = lines.float()
    share = 1.0 / weight.sum().clamp(min=1.0)
    off = (seen.pixels - pixels[:, :N_LINE]).norm(dim=-1)
    huber = F.smooth_l1_loss(seen.pixels, pixels[:, :N_LINE], reduction="none").sum(-1)
    heat = -(_target(seen.heat, pixels[:, :N_LINE]) * seen.heat.flatten(2).log_softmax(-1)).sum(-1)
    doubt = seen.log_sigma + off.detach() * torch.exp(-seen.log_sigma)
    known = F.binary_cross_entropy_with_logits
    return (
        share * (weight * (0.5 * huber + 0.5 * heat + 0.3 * doubt)).sum()
        + 0.5 * known(seen.inside, weight)
        + 0.5 * known(seen.visible, shown[:, :N_LINE].float())
        + _radius_loss(seen.log_radius[:, :N_WIDE], frames.radius, weight[:, :N_WIDE])
        + _dense_loss(seen.dense, pixels, shown)
        + _offset_loss(seen.offset, pixels, shown)
        + 0.5 * known(seen.flags, frames.flags.float())
    )


def _radius_loss(log_radius: Tensor, radius: Tensor, weight: Tensor) -> Tensor:
    """Return the loss of the apparent radii of tubes and gallbladder, where the frame has them."""
    known = radius.clamp(min=LEAST_PX).log()
    each = F.smooth_l1_loss(log_radius, known, reduction="none", beta=0.1)
    return (weight * each).sum() / weight.sum().clamp(min=1.0)


def _target(maps: Tensor, pixels: Tensor) -> Tensor:
    """Return a normal distribution (b, n, h * w) around each pixel."""
    spread = _bump(maps, pixels, HEAT_PX).flatten(2)
    return spread / (spread.sum(-1, keepdim=True) + 1e-6)


def _bump(maps: Tensor, pixels: Tensor, spread_px: float) -> Tensor:
    """Return bells (b, n, h, w), 1 at each pixel (b, n, 2)."""
    column, row = axes(maps)
    across = torch.exp(-(column - pixels[..., :1]).square() / (2.0 * spread_px**2))
    down = torch.exp(-(row - pixels[..., 1:]).square() / (2.0 * spread_px**2))
    return across[:, :, None, :] * down[..., None]


def _dense_loss(dense: Tensor, pixels: Tensor, shown: Tensor) -> Tensor:
    """Return the loss of the evidence of clips and cut ends that the picture shows."""
    targets = [
        (_bump(dense, pixels[:, g], DENSE_PX) * shown[:, g, None, None]).amax(1) for g in GROUPS
    ]
    target = torch.stack(targets, dim=1)
    each = F.binary_cross_entropy_with_logits(dense, target, reduction="none")
    return 20.0 * (each * (1.0 + FOUND * target)).mean()


def _offset_loss(offset: Tensor, pixels: Tensor, shown: Tensor) -> Tensor:
    """Return the loss of the offsets from cells near a clip or a cut end to the nearest one."""
    cells = torch.stack(torch.meshgrid(*axes(offset), indexing="xy"))  # (2, h, w)
    total = offset.new_zeros(())
    for k, group in enumerate(GROUPS):
        off = pixels[:, group, :, None, None] - cells  # (b, n, 2, h, w)
        away = off.square().sum(dim=2).masked_fill(~shown[:, group, None, None], torch.inf)
        nearest_px2, which = away.min(dim=1)
        which = which[:, None, None].expand(-1, -1, 2, -1, -1)
        wanted = off.gather(1, which)[:, 0]
        near = (nearest_px2 < NEXT_PX**2)[:, None]
        wanted = torch.where(near, wanted, 0.0)
        each = F.smooth_l1_loss(offset[:, k], wanted, reduction="none", beta=0.3)
        total = total + (near * each).sum() / near.sum().clamp(min=1)
    return total
