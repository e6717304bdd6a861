"""Follow the grasper's hold on the gallbladder, from contact: vertices, pinch and start time."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from statistics import median

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import INFUNDIBULUM_SEGMENTS, Organ
from tissue_sim.thresholds import GRASP_MAX_SLIP_M

LEFT_FINGERS, RIGHT_FINGERS = (2, 3), (6, 7)  # rows of the contact shapes
INFUNDIBULUM_RINGS = INFUNDIBULUM_SEGMENTS + 1


@dataclass(frozen=True, kw_only=True)
class Grasp:
    """A hold of tissue between both jaws of the left arm.

    Attributes:
        vertices: Held sac vertices; empty unless both jaws hold tissue.
        place_tool_m: (n, 3), place of each vertex in the tool frame when the jaws caught it.
        since_s: Start time of the hold; a slip restarts it.
        slip_m: Distance that the tissue has moved in the jaws since the start.
        pinch_n: Normal force between jaws and tissue, the smaller of the two jaws.
        traction_n: Net force of the tissue on the jaws.
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
    """Return the current grasp, from the grasp one control step ago."""
    sac = organ.sac_rings[:INFUNDIBULUM_RINGS].ravel()
    touching = tissue.host("contact_shape")[b][sac]
    held = [sac[touching == finger] for finger in LEFT_FINGERS]
    if not all(len(h) for h in held):
        return Grasp(since_s=time_s)
    forces = [tissue.host("contact_force")[b][h].astype(float) for h in held]
    total = forces[0].sum(axis=0) + forces[1].sum(axis=0)
    vertices = np.concatenate(held)
    offsets = tissue.positions(b)[vertices].astype(float) - T_world_tool[:3, 3]
    places = [tuple(p) for p in (offsets @ T_world_tool[:3, :3]).tolist()]
    now = dict(zip(vertices.tolist(), places, strict=True))
    caught = now | dict(zip(before.vertices, before.place_tool_m, strict=True))
    slip = median(hypot(p[0] - caught[v][0], p[2] - caught[v][2]) for v, p in now.items())
    slipped = slip >= GRASP_MAX_SLIP_M or not before.vertices
    return Grasp(
        vertices=tuple(now),
        place_tool_m=tuple(now.values()) if slipped else tuple(caught[v] for v in now),
        since_s=time_s if slipped else before.since_s,
        slip_m=slip,
        pinch_n=pinch_n(tissue, sac, LEFT_FINGERS, T_world_tool, b),
        traction_n=float(np.linalg.norm(total)),
    )


def pinch_n(
    tissue: Tissue, vertices: Indices, fingers: tuple[int, int], T_world_tool: Array, b: int = 0
) -> float:
    """Return the normal force of two jaws on vertices, the smaller of both; zero if one is free."""
    return min(map(abs, inward_n(tissue, vertices, fingers, T_world_tool, b)))


def inward_n(
    tissue: Tissue, vertices: Indices, fingers: tuple[int, int], T_world_tool: Array, b: int = 0
) -> tuple[float, float]:
    """Return the normal forces (N) of the upper (+y of the tool) and lower jaw, inward.

    A force is negative where a jaw presses outward, as in tissue in which the jaws were opened.
    """
    touching = tissue.host("contact_shape")[b, vertices]
    across = tissue.host("contact_force")[b, vertices].astype(float) @ T_world_tool[:3, 1]
    upper, lower = (float(across[touching == finger].sum()) for finger in fingers)
    return -upper, lower
