"""Read labelled frames of one view for training, and change them at random."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional as F

from controller.dataset.part import one_line
from planner.learning.files import DAMAGED
from tissue_sim.sensing.observation import N_SHOWN
from tissue_sim.sensing.picture_faults import smoked, splashed

TURN_RAD, GROW, SHIFT = 0.3, 0.15, 0.1  # largest; of the size: natural logarithm, share
SMOKED, SPLASHED, DEAD = 0.15, 0.15, 0.03  # shares of spoilt pictures; assumed
MOST_SMOKE, MOST_BLOOD = 0.6, 0.25
OPAQUE = 0.5  # cover through which nothing is visible
NOWHERE_PX = -1e4
LIGHT, TINT, OFFSET, NOISE = 0.3, 0.12, 0.04, 0.01  # standard deviations; assumed
_UNREADABLE = (  # what numpy raises for a file that is damaged or of another kind
    *DAMAGED, LookupError, OSError, RuntimeError, TypeError, ValueError,
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Frames:
    """Frames of one view.

    Attributes:
        rgb: (n, height, width, 3) pictures, uint8.
        pixels: (n, n_shown, 2) pixels of the labelled points.
        there: (n, n_shown) whether the points exist.
        visible: (n, n_shown) whether the picture shows the points.
        radius: (n, `N_WIDE`) apparent radii of tubes and gallbladder, pixels.
        flags: (n, 4) flags of `network.FLAGS`.
    """

    rgb: Tensor
    pixels: Tensor
    there: Tensor
    visible: Tensor
    radius: Tensor
    flags: Tensor

    def __len__(self) -> int:
        return len(self.rgb)

    def some(self, which: Tensor) -> Frames:
        """Return the frames with these indices."""
        return Frames(**{name: part[which] for name, part in vars(self).items()})

    def to(self, device: str) -> Frames:
        """Return the frames on a device."""
        return Frames(**{name: part.to(device) for name, part in vars(self).items()})

    @property
    def digest(self) -> str:
        """Return the digest of all data that training reads, in hex."""
        digest = sha256()
        for part in vars(self).values():
            digest.update(np.ascontiguousarray(part.numpy(force=True)).data)
        return digest.hexdigest()


def read_frames(files: Sequence[Path], view: str) -> Frames:
    """Read a view's frames of many episodes.

    Raises:
        ValueError: A file is damaged or has no labelled frames, or its arrays have other shapes
            than the first file's. The message is one line.
    """
    parts = [_read(path, view) for path in files]
    shapes = [{name: array.shape[1:] for name, array in part.items()} for part in parts]
    for path, found in zip(files, shapes, strict=True):
        if found != shapes[0]:
            raise ValueError(f"{path}: a frame has the shapes {found}, not {shapes[0]}")
    return Frames(**{n: torch.from_numpy(np.concatenate([p[n] for p in parts])) for n in parts[0]})


def _read(path: Path, view: str) -> Mapping[str, NDArray]:
    try:
        with np.load(path) as file:
            if (n := file["there"].shape[-1]) != N_SHOWN:
                raise ValueError(f"its frames label {n} points, not {N_SHOWN}")
            third = np.broadcast_to(file["third_tube"][:, None] > 0.5, (len(file["there"]), 1))
            return {
                "rgb": file[f"rgb.{view}"],
                "pixels": file[f"pixels.{view}"],
                "there": file["there"],
                "visible": file[f"visible.{view}"],
                "radius": file[f"radius.{view}"],
                "flags": np.concatenate([file["severed"], third], axis=1),
            }
    except _UNREADABLE as error:
        why = one_line(error)
        raise ValueError(f"{path}: it is damaged, or has no labelled frames: {why}") from error


def changed(frames: Frames, chance: torch.Generator) -> tuple[Tensor, Frames]:
    """Return pictures (b, 3, height, width), 0 to 1, with other light and moved, and their labels.

    The returned frames keep their own `rgb`.
    """
    pictures = frames.rgb.permute(0, 3, 1, 2).float() / 255.0
    pictures, labels = _moved(pictures, frames, chance)
    n, device = len(pictures), pictures.device

    def draw(*shape: int) -> Tensor:
        return torch.randn(*shape, generator=chance, device=device)

    light = torch.exp(LIGHT * draw(n, 1, 1, 1) + TINT * draw(n, 3, 1, 1))
    pictures, labels = _spoilt(pictures, labels, chance)
    pictures = pictures * light + OFFSET * draw(n, 3, 1, 1) + NOISE * draw(*pictures.shape)
    return pictures, labels


def _spoilt(pictures: Tensor, frames: Frames, chance: torch.Generator) -> tuple[Tensor, Frames]:
    """Return pictures, some spoilt by smoke, blood on the lens, or a dead camera."""
    n, device = len(pictures), pictures.device
    drawn = torch.rand(5, n, generator=chance, device=device)
    pictures = smoked(pictures, MOST_SMOKE * drawn[0] * (drawn[1] < SMOKED), chance)
    pictures, cover = splashed(pictures, MOST_BLOOD * drawn[2] * (drawn[3] < SPLASHED), chance)
    size = frames.pixels.new_tensor([pictures.shape[3], pictures.shape[2]])
    at = (2.0 * frames.pixels / size - 1.0).clamp(-2.0, 2.0)[:, None]
    covered = F.grid_sample(cover, at, align_corners=False)[:, 0, 0] > OPAQUE
    dead = drawn[4] < DEAD
    pixels = torch.where(dead[:, None, None], NOWHERE_PX, frames.pixels)
    pictures = pictures * ~dead[:, None, None, None]
    return pictures, replace(frames, pixels=pixels, visible=frames.visible & ~covered)


def _moved(pictures: Tensor, frames: Frames, chance: torch.Generator) -> tuple[Tensor, Frames]:
    """Return pictures and labels, turned, scaled and shifted alike."""
    n, _, height, width = pictures.shape
    device = pictures.device
    drawn = 2.0 * torch.rand(n, 4, generator=chance, device=device) - 1.0
    turn, grow = TURN_RAD * drawn[:, 0], torch.exp(GROW * drawn[:, 1])
    size = torch.tensor([width, height], device=device, dtype=torch.float32)
    shift = SHIFT * drawn[:, 2:] * size
    cos, sin = torch.cos(turn) / grow, torch.sin(turn) / grow
    back = torch.stack([torch.stack([cos, -sin], -1), torch.stack([sin, cos], -1)], -2)
    scaled = back * size[None, None] / size[None, :, None]
    offset = -(back @ shift[..., None]) * 2.0 / size[:, None]
    grid = F.affine_grid(torch.cat([scaled, offset], -1), list(pictures.shape), align_corners=False)
    moved = F.grid_sample(pictures, grid, align_corners=False)
    ahead = torch.linalg.inv(back)
    pixels = (frames.pixels - 0.5 * size) @ ahead.transpose(1, 2) + 0.5 * size + shift[:, None]
    return moved, replace(frames, pixels=pixels, radius=frames.radius * grow[:, None])
