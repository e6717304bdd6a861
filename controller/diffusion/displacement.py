"""Augment demonstrations: displaced tools that are led back, narrow jaws, corrections at their end.

Near tissue the expert's motion is never disturbed. Demonstrations therefore do not show how to
correct an error there, and a policy does not learn the correction. The pose of a tool that touches
nothing can be changed in a record afterwards. Its jaws, which the expert opens before it moves, can
be changed too. The method follows the shifted cameras of Bojarski et al., "End to end learning for
self-driving cars", arXiv 1604.07316.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from controller.diffusion.chunk_frame import JAW, JAWS, MOVE
from controller.diffusion.command import NONE, of_jaws, ways_of
from controller.diffusion.windows import Batch
from controller.expert.motion import JAW_SPEED_RAD_S
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.sensing.observation import fields

# Standard deviation along each axis. It must exceed the errors of the observation, or a policy
# learns that it is at its place already, wherever it observes itself.
DISPLACED_M = 8e-4
OPEN_RAD, FREE_N = 0.15, 0.01  # tools that are open wider and pressed less touch nothing
NEAR_M = 0.015  # of tissue; farther away the expert is disturbed, and closes no jaws
BACK_STEPS = 4.0  # motions after which an error is down to 1/e, from any motion on
ARRIVED = 0.12  # share of the corrections at their end; assumed
BEYOND = (0.003, 0.1)  # the most, m and rad
NARROWED = 0.3  # share of the free tools far from tissue whose jaws are half shut; assumed


def displaced(seen: Batch, generator: torch.Generator) -> Batch:
    """Return windows in which each tool that is free and near tissue is displaced throughout.

    The displacement (B, 2, 3), endoscope frame, is drawn once for each window and tool. `seen` is
    unchanged. The chunk leads the tool back, but not under a correction, which goes the same way
    from any place.
    """
    history = seen.history.clone()
    parts = fields(history)  # views
    chance = torch.randn(len(history), 2, 3, generator=generator, device=generator.device)
    off_m = DISPLACED_M * chance.to(history) * (seen.near & seen.free)[..., None]
    parts["tips_endoscope"][..., 3] += off_m[:, None]
    back = _back(seen.chunk) * (seen.correction == NONE)[:, None]
    chunk = seen.chunk.unflatten(-1, (2, -1)).clone()
    chunk[..., MOVE] -= back[:, :, None, None] * off_m[:, None]
    return seen._replace(history=history, chunk=chunk.flatten(-2))


def half_shut(seen: Batch, generator: torch.Generator) -> Batch:
    """Return windows in which some free tools far from tissue open jaws that are half shut.

    The opening, from the present one to `OPEN_RAD`, is drawn once for each window and tool. The
    jaws are unchanged under a correction of the jaws. `seen` is unchanged.
    """
    asked = of_jaws().to(seen.correction.device)[seen.correction - NONE]
    history, (B, steps) = seen.history.clone(), seen.chunk.shape[:2]
    parts = fields(history)  # views
    few = torch.rand(B, 2, generator=generator, device=generator.device) < NARROWED
    few = few.to(history.device) & ~asked[:, None] & seen.free & ~seen.near
    share = torch.rand(B, 2, generator=generator, device=generator.device).to(history) * few
    off_rad = share * (OPEN_RAD - seen.jaw_rad).clamp(max=0.0)
    parts["joints"][..., 6] += off_rad[:, None]
    jaw_rad, past, chunk = seen.jaw_rad + off_rad, seen.past.clone(), seen.chunk.clone()
    past[..., JAWS] += off_rad[:, None]
    opened = CONTROL_PERIOD_S * JAW_SPEED_RAD_S * torch.arange(1, steps + 1, device=chunk.device)
    soonest_rad = jaw_rad[:, None] + opened[:, None]
    jaws_rad = torch.minimum(chunk[..., JAWS], soonest_rad)
    chunk[..., JAWS] = torch.where(few[:, None], jaws_rad, chunk[..., JAWS])
    return seen._replace(history=history, jaw_rad=jaw_rad, past=past, chunk=chunk)


def arrived(seen: Batch, generator: torch.Generator) -> Batch:
    """Return windows in which some corrections have gone their way, or too far; arms go back by it.

    The expert rests at the end of a way for a moment only, and never goes too far. Jaws that went
    too far rest. `seen` is unchanged.
    """
    B, device = len(seen.task), seen.chunk.device
    corrected, jaws = seen.correction != NONE, of_jaws().to(device)[seen.correction - NONE]
    draws = torch.rand(B, 2, generator=generator, device=generator.device).to(seen.left)
    done = corrected & (draws[:, 0] < ARRIVED)
    beyond = -draws[:, 1:] * seen.left.new_tensor(BEYOND)
    named = torch.stack([~jaws, jaws], dim=-1)
    left = torch.where(done[:, None] & named, beyond, seen.left)
    resting = torch.zeros_like(seen.chunk).unflatten(-1, (2, -1))
    resting[..., [3, 7]], resting[..., JAW] = 1.0, seen.jaw_rad[:, None]
    off_m = beyond[:, :1, None] * ways_of(seen.correction)
    resting[..., MOVE] = _back(seen.chunk)[None, :, None, None] * off_m[:, None]
    chunk = torch.where(done[:, None, None], resting.flatten(-2), seen.chunk)
    return seen._replace(left=left, chunk=chunk, valid=seen.valid | done[:, None])


def _back(chunk: Tensor) -> Tensor:
    """Return the share (H,) of an error that each motion of chunks (B, H, 20) has led back."""
    rows = torch.arange(1, chunk.shape[1] + 1, device=chunk.device)
    return 1.0 - torch.exp(-rows / BACK_STEPS)


def free_and_near(exact: NDArray[np.float32]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return (n, 2) which tools touch nothing, and which are near tissue.

    Args:
        exact: (n, `VECTOR_SIZE`) the states without errors.
    """
    parts = fields(exact)
    opened, force_n = parts["joints"][..., 6] > OPEN_RAD, parts["forces_n"]
    tubes_m = parts["tubes_m"].reshape(len(exact), -1, 3)
    points = np.concatenate([tubes_m, parts["sac_m"]], axis=1)
    off_m = parts["tips_endoscope"][:, :, None, :, 3] - points[:, None]
    near = (np.linalg.norm(off_m, axis=-1) < NEAR_M).any(axis=-1)
    return opened & (np.linalg.norm(force_n, axis=-1) < FREE_N), near
