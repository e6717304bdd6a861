"""Free tools set off their way a little, in training, and chunks that take them back to it.

Near tissue the expert's motion is never disturbed, so that demonstrations alone do not show what
to do about an error there; a policy that never sees one leaves it as it is. The place of a tool
that touches nothing may be changed in a record afterwards, though. After the shifted cameras of
Bojarski et al., "End to end learning for self-driving cars", arXiv 1604.07316.
"""

from __future__ import annotations

import torch
from torch import Tensor

from controller.diffusion.chunk_frame import MOVE
from controller.diffusion.windows import Batch
from tissue_sim.observation import fields

DISPLACED_M = 4e-4  # standard deviation each way; clips of a policy without it missed by 0.2-0.4 mm
OPEN_RAD, FREE_N = 0.15, 0.01  # tools open wider and pressed less touch nothing
NEAR_M = 0.015  # of tissue that is seen; farther off the expert itself is disturbed
BACK_STEPS = 4.0  # after so many motions an error is down to 1/e, whichever motion it is seen at


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


def _near(parts: dict[str, Tensor]) -> Tensor:
    """(B, 2) which tools have tissue before them now."""
    points = torch.cat([parts[name][:, 0] for name in ("left_tube_m", "right_tube_m", "sac_m")], 1)
    tips = parts["tips_endoscope"][:, 0, :, None, :, 3]
    return ((tips - points[:, None]).norm(dim=-1) < NEAR_M).any(dim=-1)


def _free(parts: dict[str, Tensor]) -> Tensor:
    """(B, 2) which tools touch nothing, in no frame of a history."""
    opened, force_n = parts["joints"][..., 6] > OPEN_RAD, parts["forces_n"].norm(dim=-1)
    return (opened & (force_n < FREE_N)).all(dim=1)
