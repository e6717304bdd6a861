"""The grasper's hold on the gallbladder, read from contact: who is held, how firmly, since when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.organ import Organ
from tissue_sim.sweep import Indices
from tissue_sim.thresholds import GRASP_MOST_SLIP_M
from tissue_sim.tissue import Tissue

LEFT_FINGERS, RIGHT_FINGERS = (2, 3), (6, 7)  # rows of the contact shapes
INFUNDIBULUM_RINGS = 7


@dataclass(frozen=True, kw_only=True)
class Grasp:
    """A hold of tissue between both jaws of the left arm.

    Attributes:
        vertices: held sac vertices; empty when nothing is held by both jaws.
        place_tool_m: where each was in the tool frame when it was caught, (n, 3).
        since_s: when it began, or began anew after a slip.
        slip_m: how far the tissue has moved in the jaws since.
        pinch_n: normal force between jaws and tissue, the smaller of the two jaws.
        traction_n: net force of the tissue on the jaws.
    """

    vertices: tuple[int, ...] = ()
    place_tool_m: tuple[tuple[float, ...], ...] = ()
    since_s: float = 0.0
    slip_m: float = 0.0
    pinch_n: float = 0.0
    traction_n: float = 0.0


def follow_grasp(
    before: Grasp, tissue: Tissue, organ: Organ, T_world_tool: Array, time_s: float, b: int = 0
) -> Grasp:
    """The grasp now, given the grasp one control step ago."""
    touching = tissue.host("contact_shape")[b, : tissue.n_vertex(b)]
    forces = tissue.host("contact_force")[b, : tissue.n_vertex(b)].astype(float)
    sac = organ.sac_rings[:INFUNDIBULUM_RINGS].ravel()
    held = [sac[touching[sac] == finger] for finger in LEFT_FINGERS]
    if not all(len(h) for h in held):
        return Grasp(since_s=time_s)
    total = np.sum([forces[h].sum(axis=0) for h in held], axis=0)
    x = transform(inverse_pose(T_world_tool), tissue.positions(b).astype(float))
    vertices = np.concatenate(held)
    place = x[vertices]
    known = {v: p for v, p in zip(before.vertices, before.place_tool_m, strict=True)}
    for k, v in enumerate(vertices):
        place[k] = known.get(int(v), place[k])
    slip = float(np.median(np.linalg.norm((x[vertices] - place)[:, [0, 2]], axis=1)))
    slipped = slip >= GRASP_MOST_SLIP_M or not before.vertices
    return Grasp(
        vertices=tuple(int(v) for v in vertices),
        place_tool_m=tuple(map(tuple, x[vertices] if slipped else place)),
        since_s=time_s if slipped else before.since_s,
        slip_m=slip,
        pinch_n=pinch_n(tissue, sac, LEFT_FINGERS, T_world_tool, b),
        traction_n=float(np.linalg.norm(total)),
    )


def pinch_n(
    tissue: Tissue, vertices: Indices, fingers: tuple[int, int], T_world_tool: Array, b: int = 0
) -> float:
    """Normal force of two jaws on some vertices, the smaller of the two; zero if one is free."""
    touching = tissue.host("contact_shape")[b, vertices]
    along = tissue.host("contact_force")[b, vertices].astype(float) @ T_world_tool[:3, 1]
    return float(min(abs(along[touching == finger].sum()) for finger in fingers))
