"""What policies are told today: exact simulator state.

Points, forces and severed tubes are copied from the simulation without error, delay or occlusion.
No picture is analysed. `Observation` is the format; this file is its only source.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.sensing.observation import MAX_CLIPS, SAC_POINTS, TUBE_POINTS, Observation

_SAC, _CLIPS = 2 * TUBE_POINTS, 2 * TUBE_POINTS + SAC_POINTS  # where they start among the points


def exact_observation(field: Field) -> Observation:
    """Copy the field's exact state into an observation, without images."""
    to_endoscope = inverse_pose(field.T_world_endoscope)
    left, right = (field.anatomy.structure(side) for side in ("left", "right"))
    x = field.tissue.positions()
    clips = [field.clip_position_m(c)[None] for c in field.record.clips[-MAX_CLIPS:]]
    sac = x[field.organ.sac_rings[:SAC_POINTS, 0]]
    tubes = _centreline(field, x, left), _centreline(field, x, right)
    points = transform(to_endoscope, np.concatenate((*tubes, sac, *clips)))
    clips_m = np.zeros((MAX_CLIPS, 3))
    clips_m[: len(clips)] = points[_CLIPS:]
    return Observation(
        time_s=field.record.time_s,
        joints=field.arms.joints,
        tips_endoscope=to_endoscope @ field.arms.T_world_tool(),
        forces_n=field.tool_forces_n() @ field.T_world_endoscope[:3, :3],
        tools=(field.arms.mounted[0].name, field.arms.mounted[1].name),
        clip_loaded=field.record.clip_loaded,
        left_tube_m=points[:TUBE_POINTS],
        right_tube_m=points[TUBE_POINTS:_SAC],
        sac_m=points[_SAC:_CLIPS],
        clips_m=clips_m,
        n_clips=len(field.record.clips),
        severed=np.array([len(field.tubes.severed_rings(s)) > 0 for s in (left, right)]),
    )


def _centreline(field: Field, positions: NDArray[np.floating], tube: str) -> Array:
    """Return evenly spaced points (TUBE_POINTS, 3) of a tube's centreline, world frame."""
    low, high, share = _between(field.organ.neck_ring[tube] + 1)
    centres = field.tubes.below[tube][:, 0]
    start = positions[centres[low]].astype(float)
    return start + share * (positions[centres[high]].astype(float) - start)


@cache
def _between(n_ring: int) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Return the rings below and above each point, and its share of the way between (n, 1)."""
    at = np.linspace(0, n_ring - 1, TUBE_POINTS)
    low = np.minimum(at.astype(int), n_ring - 2)
    return low, low + 1, (at - low)[:, None]
