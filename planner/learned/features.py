"""Compute the features of one moment: the observation, and the time since the task was given.

The network also gets the distance of the observation from each task's criterion. For each tube it
gets the next clip or cut by the clip rule, and the room for the fewest clips. A planner that had to
learn these from demonstrations left the grasp early, and stood still where a tube takes two clips.
"""

from __future__ import annotations

from functools import partial

import torch
from torch import Tensor

from planner.correction import CORRECTIONS
from planner.procedure.cholecystectomy import TASKS
from planner.scene.next_task import RATHER_MORE
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, USUAL_CLIPS, needed_m
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.sensing.observation import fields
from tissue_sim.sensing.tissue_features import (
    FAR_SCALE_M,
    FORCE_N,
    SLACK,
    TOUCH_N,
    clips_along,
    closed_clips,
    grasp_features,
    is_duct,
    tissue_features,
    tubes_there,
)
from tissue_sim.sensing.tube_rule import by_tube
from tissue_sim.thresholds import RETRACTED_M, TAUT_MIN
from tissue_sim.tools.arms import RIGHT_ARM

N_TASKS, N_CORRECTIONS = len(TASKS), len(CORRECTIONS)
BESIDE_M = 0.003  # scale of the clips' distances from a tube
NEAR_M = 0.005  # scale of the distance that a tip lacks to have retracted
DEEDS = USUAL_CLIPS + 2  # on a tube: its clips, its cut, and none
LEAST_STD_M = 1e-4  # of a length; assumed
ROOM_M = 0.002  # scale of the length that a tube has beyond the least; assumed
SURELY = 3.0  # scale of the same in standard deviations; assumed
LONG_S, VERY_LONG_S = 3.0, 12.0  # scales of the time since a task was given


def seen_features(frames: Tensor) -> Tensor:
    """Return features (B, n), each of order one, of frames (B, `VECTOR_SIZE`)."""
    now = fields(frames)
    tips, forces_n = now["tips_endoscope"], now["forces_n"]
    there = tubes_there(now)
    parts = [
        tips[..., 3] / FAR_SCALE_M, tips[..., :3], now["joints"][..., 6],
        forces_n / FORCE_N, torch.tanh(forces_n / TOUCH_N), now["pinch_n"] / FORCE_N,
        now["n_clips"], now["clip_loaded"], now["right_tool"], now["severed"],
        *tissue_features(now), *_clips_on_tubes(now),
        there, there * straightness(now["tubes_m"]), *grasp_features(now),
        *(next_deed(now, k) for k in range(len(TUBES))), spare_room(now),
        retreat(tips[:, RIGHT_ARM, :, 3], now["tubes_m"], there),
    ]  # fmt: skip
    return torch.cat([part.flatten(1) for part in parts], dim=1)


def time_features(since_s: Tensor) -> Tensor:
    """Return features (..., 3) of the time (...,) since a task was given, fine early and late."""
    early, late = since_s / LONG_S, since_s / VERY_LONG_S
    return torch.stack([torch.tanh(early), torch.tanh(late), late.clamp(max=2.0)], dim=-1)


def spare_room(now: dict[str, Tensor]) -> Tensor:
    """Return features (B, 6) of the length that each tube has beyond the least for its clips.

    They are the length, and the length in standard deviations; zeros for a tube that is not there.
    """
    least_m = by_tube(is_duct(now), now["tube_radius_m"], partial(needed_m, n_clips=FEWEST_CLIPS))
    spare_m = now["rest_length_m"] - least_m
    stds = spare_m / now["rest_length_std_m"].clamp(min=LEAST_STD_M)
    there = tubes_there(now)
    return torch.cat([there * torch.tanh(spare_m / ROOM_M), there * torch.tanh(stds / SURELY)], 1)


def _clips_on_tubes(now: dict[str, Tensor]) -> list[Tensor]:
    """Return each clip's distance from each tube and its place along the tube."""
    parts = []
    for tube_m, there in zip(now["tubes_m"].unbind(1), tubes_there(now).split(1, 1), strict=True):
        away = torch.cdist(now["clips_m"], tube_m)  # (B, clips, points)
        nearest, along = away.min(dim=-1)
        place = there * along / (away.shape[-1] - 1.0)
        parts += [there * torch.tanh(nearest / BESIDE_M), place]
    return parts


def next_deed(now: dict[str, Tensor], k: int) -> Tensor:
    """Return the next deed on tube k: first, second, last clip, cut, none; one-hot (B, `DEEDS`)."""
    length_m = now["rest_length_m"][:, k : k + 1]
    sitting = clips_along(now["tubes_m"][:, k], length_m, now["clips_m"], closed_clips(now))
    there, needed = sitting.there.sum(dim=1), _needed(now, k)
    deed = torch.where(there == needed - 1, USUAL_CLIPS - 1, there)
    deed = torch.where(there >= needed, DEEDS - 2, deed)
    ended = (now["severed"][:, k] > 0.5) | (tubes_there(now)[:, k] < 0.5)
    deed = torch.where(ended, DEEDS - 1, deed)
    return torch.nn.functional.one_hot(deed.long(), DEEDS).to(length_m)


def _needed(now: dict[str, Tensor], k: int) -> Tensor:
    """Return the number of clips (B,) that tube k needs, as in `planner.scene.next_task`."""
    duct = is_duct(now)[:, k]
    length_m = now["rest_length_m"][:, k] + RATHER_MORE * now["rest_length_std_m"][:, k]
    usual_m = by_tube(duct, now["tube_radius_m"][:, k], needed_m)
    return torch.where(length_m < usual_m, FEWEST_CLIPS, USUAL_CLIPS)


def straightness(tubes_m: Tensor) -> Tensor:
    """Return the straightness (B, m) of tubes (B, m, n, 3); zero where one is straight enough."""
    length_m = (tubes_m[:, :, 1:] - tubes_m[:, :, :-1]).norm(dim=-1).sum(dim=-1)
    chord_m = (tubes_m[:, :, -1] - tubes_m[:, :, 0]).norm(dim=-1)
    return torch.tanh((chord_m / length_m.clamp(min=1e-6) - TAUT_MIN) / SLACK)


def retreat(tip_m: Tensor, tubes_m: Tensor, there: Tensor) -> Tensor:
    """Return distances (B, 1) of tips (B, 3) from tubes (B, m, n, 3); zero where an arm is back.

    `there` (B, m) is 1 where there is a tube, else 0.
    """
    each_m = (tubes_m - tip_m[:, None, None]).norm(dim=-1).amin(dim=-1)
    away_m = each_m.masked_fill(there < 0.5, torch.inf).amin(dim=1, keepdim=True)
    return torch.tanh((away_m - RETRACTED_M) / NEAR_M)
