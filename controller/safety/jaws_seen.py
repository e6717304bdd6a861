"""Find the structures between the right tool's jaws, from the observation alone."""

from __future__ import annotations

import numpy as np

from controller.safety.seen_obstacles import lines_seen
from planner.scene.duct_side import structure_seen
from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.patient.tubes import (
    BETWEEN_HALF_GAP_M,
    GALLBLADDER,
    SAC_HALF_GAP_M,
    TIP_EDGE_M,
)
from tissue_sim.sensing.observation import ROWS, TUBE_ROWS, Observation
from tissue_sim.tools.arms import RIGHT_ARM

NOTHING = frozenset[str]()
SURE = 1.0  # standard deviations; assumed
_ACROSS, _ALONG = np.linspace(-1.0, 1.0, 3), np.linspace(0.0, 1.0, 5)


def between_jaws_seen(observation: Observation, before: frozenset[str] = NOTHING) -> frozenset[str]:
    """Return the names of the structures that the jaws would close on for good.

    If `before` names the gallbladder, its wall was between the jaws before. Then the wall counts as
    between them until it is surely out, so that the observation's flicker opens no lock.
    """
    if observation.right_instrument.deed is None:
        return NOTHING
    T_tool_endoscope = inverse_pose(observation.tips_endoscope[RIGHT_ARM])
    reach_m, width_m = observation.right_instrument.mouth_m
    found = {
        name
        for name, line in lines_seen(observation).items()
        if any(
            crosses(
                transform(T_tool_endoscope, part_m),
                line.radius_m,
                reach_m,
                float(line.std_m.mean()),
            )
            for part_m in line.parts_m()
        )
    }
    axis, wall_m = transform(T_tool_endoscope, observation.sac_m), observation.sac_radius_m
    if GALLBLADDER in before:
        wall_m = wall_m + SURE * float(observation.std_m[ROWS["sac_m"]].mean())
    if sac_within(axis, wall_m, reach_m, width_m):
        found.add(GALLBLADDER)
    return frozenset(found)


def crosses(line: Array, radius_m: float, reach_m: float, unsure_m: float) -> bool:
    """Return whether a line (n, 3), tool frame, crosses the plane x = 0 between the jaws."""
    return len(_depths_m(line, radius_m, reach_m, unsure_m)) > 0


def _depths_m(line: Array, radius_m: float, reach_m: float, unsure_m: float) -> Array:
    """Return z (k,) of the places where a line crosses the plane x = 0 between the jaws."""
    x = line[:, 0]
    spans = np.flatnonzero((x[:-1] * x[1:] <= 0.0) & (x[:-1] != x[1:]))
    share = (x[spans] / (x[spans] - x[spans + 1]))[:, None]
    _, y, z = (line[spans] + share * (line[spans + 1] - line[spans])).T
    within = (-reach_m <= z) & (z <= radius_m) & (np.abs(y) < BETWEEN_HALF_GAP_M + unsure_m)
    return z[within]


def partly_between_seen(observation: Observation, between: frozenset[str]) -> frozenset[str]:
    """Return the tubes between the jaws of which a clip would surely hold only a part.

    A tube is pressed flat, to half its circumference (`Clip.complete`).
    """
    clip = observation.right_instrument.clip
    if clip is None or not observation.clip_loaded or not between:
        return NOTHING
    T_tool_endoscope = inverse_pose(observation.tips_endoscope[RIGHT_ARM])
    found = set()
    for tube in observation.tubes:
        if (name := structure_seen(tube, observation)) not in between:
            continue
        line = transform(T_tool_endoscope, observation.tube_m(tube))
        unsure_m = SURE * float(observation.std_m[TUBE_ROWS[tube]].mean())
        radius_m = observation.radius_m(tube)
        half_m = 0.5 * np.pi * radius_m - unsure_m
        z = _depths_m(line, radius_m, clip.length_m, unsure_m)
        if ((z + half_m > TIP_EDGE_M) | (z - half_m < -clip.length_m)).any():
            found.add(name)
    return frozenset(found)


def sac_within(axis: Array, radius_m: Array, reach_m: float, width_m: float) -> bool:
    """Return whether part of the gallbladder lies where the closing jaws meet.

    Args:
        axis: (5, 3) points of the infundibulum's axis, tool frame.
        radius_m: (5,) distances of the wall from these points.
        reach_m: Reach of the jaws.
        width_m: Width of the jaws.
    """
    grid = np.meshgrid(
        0.5 * width_m * _ACROSS, SAC_HALF_GAP_M * _ACROSS, -reach_m * _ALONG, indexing="ij"
    )
    points = np.stack([part.ravel() for part in grid], axis=1)
    start, way = axis[:-1], np.diff(axis, axis=0)
    length_sq = np.maximum(np.vecdot(way, way), np.finfo(float).tiny)
    along = np.einsum("nmk,mk->nm", points[:, None] - start, way) / length_sq
    foot = start + along[..., None] * way
    wall_m = radius_m[:-1] + along * np.diff(radius_m)
    inside = np.linalg.norm(points[:, None] - foot, axis=-1) < wall_m
    return bool((inside & (along >= 0.0) & (along <= 1.0)).any())
