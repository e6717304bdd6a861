"""Build simple bodies: boxes of one material, as real `Tissue`s; load and settle them."""

from __future__ import annotations

from typing import Any

import numpy as np

from tissue_sim.frames import AWAY, Array, axis_angle, pose, unit
from tissue_sim.mechanics.step import TissueConfig
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.topology import boundary_faces
from tissue_sim.patient.material import Material
from tissue_sim.patient.mesher import Indices, oriented
from tissue_sim.patient.organ import TUBES, Organ
from tissue_sim.patient.supports import LiverBed
from tissue_sim.patient.tubes import Tubes

EPS = float(np.finfo(np.float32).eps)
SETTLED_M = 1e-8  # per step: about the rounding of a position of a decimetre
RUBBER = Material(young_pa=50e3, poisson=0.3)
NO_GRAVITY = (0.0, 0.0, 0.0)
FAR_BED = LiverBed(
    point_m=np.array([0.0, 0.0, -9.0]),
    normal=np.array([0.0, 0.0, 1.0]),
    along=np.array([1.0, 0.0, 0.0]),
    edge_m=-9.0,
)


def box(size: tuple[float, float, float], cells: tuple[int, int, int]) -> tuple[Array, Indices]:
    """Return vertices and tetrahedra of a box from the origin, six per cell, on one diagonal."""
    axes = [np.linspace(0.0, s, n + 1) for s, n in zip(size, cells, strict=True)]
    vertices = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(vertices)).reshape([n + 1 for n in cells])
    tets = []
    for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
        corner, path = np.zeros(3, int), []
        for axis in (None, *order):
            corner[axis if axis is not None else []] += 1
            path.append(number[tuple(slice(c, c + n) for c, n in zip(corner, cells, strict=True))])
        tets.append(np.stack([p.ravel() for p in path], axis=1))
    return vertices, oriented(vertices, np.concatenate(tets)).astype(np.int32)


def organ_of(vertices: Array, tets: Indices, **given: Any) -> Organ:
    """Return an organ of one body, without tubes, ties, anchors or bed unless given."""
    none = np.zeros((1, 13), np.int32)
    parts: dict[str, Any] = {
        "region": np.zeros(len(tets), np.int32),
        "fixed": np.zeros(len(vertices), bool),
        "rings": dict.fromkeys(TUBES, none),
        "neck_ring": dict.fromkeys(TUBES, -1),
        "sac_rings": none,
        "tie_vertex": np.zeros(0, np.int32),
        "tie_corners": np.zeros((0, 4), np.int32),
        "tie_weights": np.zeros((0, 4)),
        "bed_vertices": np.zeros(0, np.int32),
        "ligament_vertices": np.zeros(0, np.int32),
        "remnants": np.zeros((0, 2), np.int32),
        "bed": FAR_BED,
    }
    return Organ(vertices=vertices, tets=tets, **(parts | given))


def tissue_of(organ: Organ, material: Material | None = RUBBER, **config: Any) -> Tissue:
    """Return the organ as tissue, of one material unless the material is None.

    The tissue is solved tightly, without gravity and damping unless configured.
    """
    tight = {
        "gravity_m_s2": NO_GRAVITY,
        "damping_per_s": 0.0,
        "viscosity_s": 0.0,
        "iterations": 400,
        "tolerance": 1e-6,
        "settled_j": 0.0,
    }
    tissue = Tissue([organ], config=TissueConfig(**(tight | config)))
    if material is not None:
        tissue.host("mu")[:], tissue.host("lam")[:] = material.lame
        tissue.host("shear")[:], tissue.host("bulk")[:] = material.lame
    return tissue


def put(tissue: Tissue, positions: Array) -> Array:
    """Move the vertices to positions (n, 3), at rest; return the tissue's rounded positions."""
    tissue.positions()[:] = positions
    tissue.host("velocity")[:] = 0.0
    return tissue.positions().astype(float)


def overdamped(vertices: Array, tets: Indices, material: Material, **organ: Any) -> Tissue:
    """Return a body with so much damping that its motion does not overshoot."""
    return tissue_of(
        organ_of(vertices, tets, **organ), material, step_s=0.002, damping_per_s=2000.0
    )


def settle(tissue: Tissue, load: Array | None = None, max_steps: int = 400) -> Array:
    """Step under a load (n, 3) N until nothing moves; return the positions.

    Raises:
        ArithmeticError: the body still moves after `max_steps` steps.
    """
    if load is not None:
        tissue.host("load")[0, : tissue.n_vertex()] = load
    for _ in range(max_steps):
        before = tissue.positions().astype(float)
        tissue.step()
        if np.abs(tissue.positions() - before).max() < SETTLED_M:
            return tissue.positions().astype(float)
    raise ArithmeticError("the body does not settle")


def face_share(vertices: Array, tets: Indices, axis: int, at: float) -> Array:
    """Return the (n_vertex,) area of a plane side of the body per vertex, m^2."""
    faces, _ = boundary_faces(tets)
    corners = vertices[faces]
    side = np.isclose(corners[:, :, axis], at).all(axis=1)
    edges = corners[side, 1:] - corners[side, :1]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    share = np.zeros(len(vertices))
    np.add.at(share, faces[side], area[:, None] / 3)
    return share


def astride(
    tubes: Tubes, tube: str, station_m: float, *, beyond_m: float, askew_rad: float = 0.0
) -> Array:
    """Return `T_world_tool` of jaws that close square across a tube at a station, from the front.

    The tip is `beyond_m` beyond the tube's centre; `askew_rad` turns the jaws about their own axis.
    """
    point, along = tubes.point(tube, station_m)
    z = unit(AWAY - (AWAY @ along) * along)
    T = pose(np.stack([along, np.cross(z, along), z], axis=1), point + beyond_m * z)
    T[:3, :3] = axis_angle(z, askew_rad) @ T[:3, :3]
    return T
