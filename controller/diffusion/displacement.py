"""Free tools set off their way a little, in training, and chunks that take them back to it.

Near tissue the expert's motion is never disturbed, so that demonstrations alone do not show what
to do about an error there; a policy that never sees one leaves it as it is. The place of a tool
that touches nothing may be changed in a record afterwards, though, and so may its jaws, which the
expert opens before it moves on. After the shifted cameras of Bojarski et al., "End to end learning
for self-driving cars", arXiv 1604.07316.
"""

from __future__ import annotations

import torch
from torch import Tensor

from controller.diffusion.chunk_frame import JAWS, MOVE
from controller.diffusion.windows import Batch
from controller.expert.motion import JAW_SPEED_RAD_S
from tissue_sim.periods import CONTROL_PERIOD_S
from tissue_sim.sensing.observation import fields

DISPLACED_M = 4e-4  # standard deviation each way; clips of a policy without it missed by 0.2-0.4 mm
OPEN_RAD, FREE_N = 0.15, 0.01  # tools open wider and pressed less touch nothing
NEAR_M = 0.015  # of tissue that is seen; farther off the expert is disturbed, and closes no jaws
BACK_STEPS = 4.0  # after so many motions an error is down to 1/e, whichever motion it is seen at
NARROWED = 0.3  # share of the free tools far from tissue whose jaws are half shut; assumed


def displaced(seen: Batch, generator: torch.Generator) -> Batch:
    """Windows in which each tool that is near tissue but free stands some way off, all along.

    The way off is drawn once a window and tool, (B, 2, 3) in the endoscope's frame; `seen` stays.
    """
    history = seen.history.clone()
    parts = fields(history)  # views
    chance = torch.randn(len(history), 2, 3, generator=generator, device=generator.device)
    off_m = DISPLACED_M * chance.to(history) * (_near(parts) & _free(parts))[..., None]
    parts["tips_endoscope"][..., 3] += off_m[:, None]
    rows = torch.arange(1, seen.chunk.shape[1] + 1, device=seen.chunk.device)
    back = 1.0 - torch.exp(-rows / BACK_STEPS)
    chunk = seen.chunk.unflatten(-1, (2, -1)).clone()
    chunk[..., MOVE] -= back[:, None, None] * off_m[:, None]
    return seen._replace(history=history, chunk=chunk.flatten(-2))


def half_shut(seen: Batch, asked: Tensor, generator: torch.Generator) -> Batch:
    """Windows in which some free tools far from tissue have their jaws half shut, and open them.

    How far is drawn once a window and tool, from as they are to `OPEN_RAD`; `seen` stays.

    Args:
        asked: (B,) the words are about the jaws, which are as they should be.
    """
    history, (B, steps) = seen.history.clone(), seen.chunk.shape[:2]
    parts = fields(history)  # views
    few = torch.rand(B, 2, generator=generator, device=generator.device) < NARROWED
    few = few.to(history.device) & ~asked[:, None] & _free(parts) & ~_near(parts)
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


def _near(parts: dict[str, Tensor]) -> Tensor:
    """(B, 2) which tools have tissue before them now."""
    points = torch.cat([parts[name][:, 0] for name in ("left_tube_m", "right_tube_m", "sac_m")], 1)
    tips = parts["tips_endoscope"][:, 0, :, None, :, 3]
    return ((tips - points[:, None]).norm(dim=-1) < NEAR_M).any(dim=-1)


def _free(parts: dict[str, Tensor]) -> Tensor:
    """(B, 2) which tools touch nothing, in no frame of a history."""
    opened, force_n = parts["joints"][..., 6] > OPEN_RAD, parts["forces_n"].norm(dim=-1)
    return (opened & (force_n < FREE_N)).all(dim=1)
