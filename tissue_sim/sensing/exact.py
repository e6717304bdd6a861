"""From the world to what a policy may see of it."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.sensing.observation import MAX_CLIPS, SAC_POINTS, TUBE_POINTS, Observation

if TYPE_CHECKING:
    from tissue_sim.world import World

_SAC, _CLIPS = 2 * TUBE_POINTS, 2 * TUBE_POINTS + SAC_POINTS  # where they start among the points


def observe(world: World) -> Observation:
    """The world as seen now, without images."""
    to_endoscope = inverse_pose(world.T_world_endoscope)
    left, right = (world.anatomy.structure(side) for side in ("left", "right"))
    x = world.tissue.positions()
    clips = [world.clip_position_m(c)[None] for c in world.record.clips[-MAX_CLIPS:]]
    sac = x[world.organ.sac_rings[:SAC_POINTS, 0]]
    tracked = _tracked(world, x, left), _tracked(world, x, right)
    seen = transform(to_endoscope, np.concatenate((*tracked, sac, *clips)))
    clips_m = np.zeros((MAX_CLIPS, 3))
    clips_m[: len(clips)] = seen[_CLIPS:]
    return Observation(
        time_s=world.record.time_s,
        joints=world.arms.joints,
        tips_endoscope=to_endoscope @ world.arms.T_world_tool(),
        forces_n=world.tool_forces_n() @ world.T_world_endoscope[:3, :3],
        tools=(world.arms.mounted[0].name, world.arms.mounted[1].name),
        clip_loaded=world.record.clip_loaded,
        left_tube_m=seen[:TUBE_POINTS],
        right_tube_m=seen[TUBE_POINTS:_SAC],
        sac_m=seen[_SAC:_CLIPS],
        clips_m=clips_m,
        n_clips=len(world.record.clips),
        severed=np.array([len(world.tubes.severed_rings(s)) > 0 for s in (left, right)]),
    )


def _tracked(world: World, positions: NDArray[np.floating], tube: str) -> Array:
    """(TUBE_POINTS, 3) evenly spaced points of a tube's centreline, world frame."""
    low, high, share = _between(world.organ.neck_ring[tube] + 1)
    centres = world.tubes.below[tube][:, 0]
    start = positions[centres[low]].astype(float)
    return start + share * (positions[centres[high]].astype(float) - start)


@cache
def _between(n_ring: int) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """For each tracked point the rings below and above it, and its share of the way (n, 1)."""
    at = np.linspace(0, n_ring - 1, TUBE_POINTS)
    low = np.minimum(at.astype(int), n_ring - 2)
    return low, low + 1, (at - low)[:, None]
