"""Implement the sense `exact`: simulator state, without error, delay or occlusion.

No robot has this sense.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import Array, cross, inverse_pose, transform
from tissue_sim.patient.at_risk import AT_RISK
from tissue_sim.patient.mesher import ring_radii_m
from tissue_sim.patient.tube_names import TUBES, USUAL_TUBES
from tissue_sim.sensing.observation import (
    MAX_CLIPS,
    N_POINTS,
    ROWS,
    SAC_POINTS,
    TRUNK_POINTS,
    TUBE_POINTS,
    Observation,
    points_by_name,
)
from tissue_sim.sensing.sensor_model import SenseSetup
from tissue_sim.tools.instruments import PATCH_LINKS


class SenseExact:
    """Returns the exact state."""

    def observe(self, world: Field, exact: Observation) -> Observation:
        """Return the field's exact state."""
        return exact


def make(setup: SenseSetup) -> SenseExact:
    """Return the sense; nothing in its setup concerns it."""
    del setup
    return SenseExact()


def exact_observation(field: Field) -> Observation:
    """Copy the field's exact state into an observation, without images."""
    to_endoscope = inverse_pose(field.T_world_endoscope)
    x = field.tissue.positions()
    clips = [field.clip_position_m(c)[None] for c in field.record.clips[-MAX_CLIPS:]]
    sac = x[field.organ.sac_rings[:SAC_POINTS, 0]]
    tubes = [_centreline(field, x, tube, TUBE_POINTS) for tube in _structures(field)]
    trunks = [_centreline(field, x, trunk, TRUNK_POINTS) for trunk in AT_RISK]
    tubes_m = transform(to_endoscope, np.concatenate(tubes))
    others_m = transform(to_endoscope, np.concatenate((sac, *trunks, *clips)))
    points, n = np.zeros((N_POINTS, 3)), ROWS["tubes_m"].stop
    points[: len(tubes_m)], points[n : n + len(others_m)] = tubes_m, others_m
    hidden = (np.arange(N_POINTS) >= len(tubes_m)) & (np.arange(N_POINTS) < n)
    return Observation(
        time_s=field.record.time_s,
        joints=field.arms.joints,
        tips_endoscope=to_endoscope @ field.arms.T_world_tool(),
        forces_n=field.tool_forces_n() @ field.T_world_endoscope[:3, :3],
        pinch_n=field.record.grasp.pinch_n,
        tools=(field.arms.mounted[0].name, field.arms.mounted[1].name),
        clip_loaded=field.record.clip_loaded,
        clip_kinds=tuple(clip.kind.name for clip in field.record.clips),
        **points_by_name(points),
        n_clips=len(field.record.clips),
        **_of_tubes(field),
        third_tube=float(field.anatomy.second_artery is not None),
        hidden=hidden,
        sac_radius_m=ring_radii_m(x, field.organ.sac_rings[:SAC_POINTS]),
        T_world_endoscope=field.T_world_endoscope,
        shaft_offset_m=_shaft_offset_m(field),
    )


def _structures(field: Field) -> list[str]:
    """Return the structures of the tubes that are there, in the order of `TUBES`."""
    tubes = TUBES if field.anatomy.second_artery else USUAL_TUBES
    return [field.anatomy.structure(tube) for tube in tubes]


def _of_tubes(field: Field) -> dict[str, Any]:
    """Return whether each tube is severed, its radius and its length; zeros without a third."""
    severed, radius_m, length_m = np.zeros(len(TUBES), bool), *np.zeros((2, len(TUBES)))
    for k, tube in enumerate(_structures(field)):
        severed[k] = len(field.tubes.severed_rings(tube)) > 0
        radius_m[k], length_m[k] = field.tubes.radius_m(tube), field.tubes.length_m[tube]
    return {"severed": severed, "tube_radius_m": radius_m, "rest_length_m": length_m}


def _shaft_offset_m(field: Field) -> Array:
    """Return (2,) the distances of the shafts' lines from the remote centres."""
    shafts = field.tissue.T_world_links()[:: len(PATCH_LINKS)].astype(float)
    from_rcm_m = shafts[:, :3, 3] - field.arms.T_world_rcm[:, :3, 3]
    moments_m = [cross(*arm) for arm in zip(from_rcm_m, shafts[:, :3, 2], strict=True)]
    return np.linalg.norm(moments_m, axis=1)


def _centreline(field: Field, positions: NDArray[np.floating], tube: str, n_point: int) -> Array:
    """Return evenly spaced points (n_point, 3) of a centreline, world frame.

    No point lies in the gap of a cut, which parts the two copies of a ring.
    """
    low, high, share = _between(field.organ.neck_ring[tube] + 1, n_point)
    below, above = field.tubes.below[tube][:, 0], field.tubes.above[tube][:, 0]
    start = positions[np.where(share[:, 0] > 0.0, above[low], below[low])].astype(float)
    return start + share * (positions[below[high]].astype(float) - start)


@cache
def _between(n_ring: int, n_point: int) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Return the rings below and above each point, and the point's share of the way (n, 1)."""
    at = np.linspace(0, n_ring - 1, n_point)
    low = np.minimum(at.astype(int), n_ring - 2)
    return low, low + 1, (at - low)[:, None]
