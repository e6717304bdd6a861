"""From the world to what a policy may see of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.observation import MOST_CLIPS, SAC_POINTS, TUBE_POINTS, Observation
from tissue_sim.tubes import Tubes

if TYPE_CHECKING:
    from tissue_sim.world import World


def observe(world: World) -> Observation:
    """The world as seen now, without images."""
    to_endoscope = inverse_pose(world.T_world_endoscope)
    left, right = (world.anatomy.structure(side) for side in ("left", "right"))
    sac = world.tissue.positions()[world.organ.sac_rings[:SAC_POINTS, 0]].astype(float)
    return Observation(
        time_s=world.record.time_s,
        joints=world.arms.joints,
        tips_endoscope=to_endoscope @ world.arms.T_world_tool(),
        forces_n=world.tool_forces_n() @ world.T_world_endoscope[:3, :3],
        tools=(world.arms.mounted[0].name, world.arms.mounted[1].name),
        clip_loaded=world.record.clip_loaded,
        left_tube_m=transform(to_endoscope, _tracked(world.tubes, left)),
        right_tube_m=transform(to_endoscope, _tracked(world.tubes, right)),
        sac_m=transform(to_endoscope, sac),
        clips_m=_clips(world, to_endoscope),
        n_clips=len(world.record.clips),
        severed=np.array([len(world.tubes.severed_rings(s)) > 0 for s in (left, right)]),
    )


def _tracked(tubes: Tubes, tube: str) -> Array:
    """(TUBE_POINTS, 3) evenly spaced points of a tube's centreline, world frame."""
    centres = tubes.centres(tube)
    at = np.linspace(0, len(centres) - 1, TUBE_POINTS)
    return np.stack([np.interp(at, np.arange(len(centres)), c) for c in centres.T], axis=1)


def _clips(world: World, to_endoscope: Array) -> Array:
    """(MOST_CLIPS, 3) the latest clips in order of closing, zeros where there is none."""
    clips = np.zeros((MOST_CLIPS, 3))
    for k, clip in enumerate(world.record.clips[-MOST_CLIPS:]):
        clips[k] = transform(to_endoscope, world.clip_position_m(clip)[None])[0]
    return clips
