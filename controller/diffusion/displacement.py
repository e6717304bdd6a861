"""Open tools set off their way a little, in training, and chunks that take them back to it.

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
OPEN_RAD = 0.15  # jaws wider than this hold nothing
BACK_STEPS = 4.0  # after so many motions an error is down to 1/e, whichever motion it is seen at


def displaced(seen: Batch, generator: torch.Generator) -> Batch:
    """Windows in which each open tool stands some way off, all along, until the chunk begins."""
    history = seen.history.clone()
    parts = fields(history)  # views
    off_m = _offsets_m(parts["joints"][:, 0, :, 6], generator)
    parts["tips_endoscope"][..., 3] += off_m[:, None]
    rows = torch.arange(1, seen.chunk.shape[1] + 1, device=seen.chunk.device)
    back = 1.0 - torch.exp(-rows / BACK_STEPS)
    chunk = seen.chunk.unflatten(-1, (2, -1)).clone()
    chunk[..., MOVE] -= back[:, None, None] * off_m[:, None]
    return seen._replace(history=history, chunk=chunk.flatten(-2))


def _offsets_m(jaw_rad: Tensor, generator: torch.Generator) -> Tensor:
    """(B, 2, 3) of the tools with jaws (B, 2), in the endoscope's frame."""
    off = torch.randn(*jaw_rad.shape, 3, generator=generator, device=generator.device)
    return DISPLACED_M * off.to(jaw_rad) * (jaw_rad > OPEN_RAD)[..., None]
