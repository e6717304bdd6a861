"""What is seen of the tissue as a network takes it: where each tool has it."""

from __future__ import annotations

import torch
from torch import Tensor

from tissue_sim.observation import MOST_CLIPS

FAR_M, NEAR_M = 0.03, 0.006  # a working distance; about half a jaw's length
LENGTH_M = 0.01
FORCE_N, TOUCH_N = 2.0, 0.2
CLIPS_A_TUBE = 4  # one more than there should be
SITS_WITHIN_M = 0.003  # of the centreline; the tubes are 4 to 8 mm apart or more, assumed


def tissue_features(now: dict[str, Tensor]) -> list[Tensor]:
    """Points in the endoscope's and in each tool's frame, told apart both near and far."""
    slots = torch.arange(MOST_CLIPS, device=now["n_clips"].device)
    tubes = [now["left_tube_m"], now["right_tube_m"]]
    closed = (slots < now["n_clips"]).to(now["clips_m"].dtype)
    sitting = [clips_along(tube, now["clips_m"], closed) for tube in tubes]
    points = torch.cat([*tubes, now["sac_m"], now["clips_m"], *(s[0] for s in sitting)], dim=1)
    n_always = points.shape[1] - MOST_CLIPS - 2 * CLIPS_A_TUBE
    of_clips = torch.cat([closed, *(s[1] for s in sitting)], dim=1)
    there = torch.cat([torch.ones_like(points[:, :n_always, 0]), of_clips], dim=1)[..., None]
    tips = now["tips_endoscope"]
    off = (points[:, None] - tips[:, :, None, :, 3]) * there[:, None]  # (B, 2, n, 3)
    seen = torch.einsum("baji,banj->bani", tips[..., :3], off)
    lengths = [(tube[:, 1:] - tube[:, :-1]).norm(dim=-1).sum(dim=1, keepdim=True) for tube in tubes]
    return [
        off / FAR_M, seen / FAR_M, torch.tanh(seen / NEAR_M), of_clips,
        *(length / LENGTH_M for length in lengths),
    ]  # fmt: skip


def clips_along(tube_m: Tensor, clips_m: Tensor, closed: Tensor) -> tuple[Tensor, Tensor]:
    """The clips that sit on a tube, in their order along it, whatever the order of closing.

    Args:
        tube_m: (B, n, 3) points of its centreline.
        clips_m: (B, m, 3) all clips.
        closed: (B, m) 1 where there is a clip, else 0.

    Returns:
        Places (B, `CLIPS_A_TUBE`, 3) of the first of them, and 1 where there is one, else 0.
    """
    begin, along = tube_m[:, None, :-1], (tube_m[:, 1:] - tube_m[:, :-1])[:, None]  # (B, 1, n-1, 3)
    off = clips_m[:, :, None] - begin  # (B, m, n-1, 3)
    share = ((off * along).sum(-1) / along.square().sum(-1).clamp(min=1e-12)).clamp(0.0, 1.0)
    distance, nearest = (off - share[..., None] * along).norm(dim=-1).min(dim=-1)
    station = nearest + share.gather(-1, nearest[..., None])[..., 0]
    sits = (distance < SITS_WITHIN_M) & (closed > 0)
    order = torch.where(sits, station, torch.full_like(station, float(tube_m.shape[1])))
    first = order.topk(CLIPS_A_TUBE, dim=1, largest=False).indices
    places = clips_m.gather(1, first[..., None].expand(-1, -1, 3))
    return places, sits.gather(1, first).to(clips_m)
