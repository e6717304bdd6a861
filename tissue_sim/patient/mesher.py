"""Sweep a disc with a lumen and a wall along a centreline and divide it into tetrahedra.

Every section is a ring, so a transection plane is a set of whole faces. The same input gives the
same mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array, unit

Indices = NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """A body swept along a centreline.

    Attributes:
        vertices: (n_ring * n_section_vertices, 3), m; ring after ring.
        tets: (n_tet, 4), positively oriented.
        in_lumen: (n_tet,), whether an element lies inside the inner ring.
        station: (n_tet,), the segment k (between rings k and k + 1) of a tetrahedron.
        rings: (n_ring, 1 + 2 n_sector): centre, inner ring, outer ring.
    """

    vertices: Array
    tets: Indices
    in_lumen: NDArray[np.bool_]
    station: Indices
    rings: Indices


def sweep(centreline: Array, radius: Array, *, sectors: int, lumen: float) -> Sweep:
    """Sweep a disc along a centreline.

    Args:
        centreline: (n_ring, 3), m.
        radius: (n_ring,), outer radius, m.
        sectors: number of corners of a ring.
        lumen: inner radius over outer radius, 0 to 1.
    """
    disc, triangles, is_lumen = _disc(sectors, lumen)
    n_ring, n_disc = len(centreline), len(disc)
    side, across = section_axes(centreline)
    offset = disc[None, :, :1] * side[:, None] + disc[None, :, 1:] * across[:, None]
    vertices = (centreline[:, None] + radius[:, None, None] * offset).reshape(-1, 3)
    base = (np.arange(n_ring - 1) * n_disc)[:, None, None]
    tets = (_prism_tets(triangles, n_disc)[None] + base).reshape(-1, 4)
    per_segment = 3 * len(triangles)
    return Sweep(
        vertices=vertices,
        tets=oriented(vertices, tets).astype(np.int32),
        in_lumen=np.tile(np.repeat(is_lumen, 3), n_ring - 1),
        station=np.repeat(np.arange(n_ring - 1), per_segment).astype(np.int32),
        rings=np.arange(n_ring * n_disc, dtype=np.int32).reshape(n_ring, n_disc),
    )


def subdivide(values: Array, parts: int) -> Array:
    """Divide each step between two rows of values (n, ...) into equal parts."""
    whole, part = np.divmod(np.arange(parts * (len(values) - 1) + 1), parts)
    ahead = values[np.minimum(whole + 1, len(values) - 1)]
    return (values[whole].T + part / parts * (ahead - values[whole]).T).T


def section_axes(centreline: Array) -> tuple[Array, Array]:
    """Return two unit vectors (n, 3) across the centreline at each station, free of twist."""
    steps_m = np.linalg.norm(np.diff(centreline, axis=0), axis=1)
    tangent = unit(np.gradient(centreline, np.append(0.0, np.cumsum(steps_m)), axis=0))
    side = np.cross(tangent[0], [0.0, 0.0, 1.0])
    if np.linalg.norm(side) < 1e-3:
        side = np.cross(tangent[0], [1.0, 0.0, 0.0])
    sides = []
    for t in tangent:
        side = unit(side - (side @ t) * t)
        sides.append(side)
    sides = np.stack(sides)
    return sides, np.cross(tangent, sides)


def signed_volumes(vertices: Array, tets: Indices) -> Array:
    """Return the (n_tet,) signed volumes, m^3."""
    a, b, c, d = (vertices[tets[:, k]] for k in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0


def oriented(vertices: Array, tets: Indices) -> Indices:
    """Return the same tetrahedra, each with positive volume."""
    flip = signed_volumes(vertices, tets) < 0
    tets = tets.copy()
    tets[flip] = tets[flip][:, [0, 2, 1, 3]]
    return tets


def _disc(sectors: int, lumen: float) -> tuple[Array, Indices, NDArray[np.bool_]]:
    """Return a unit disc: points (1 + 2 sectors, 2), triangles, and which triangles are lumen."""
    angle = 2 * np.pi * np.arange(sectors) / sectors
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = np.concatenate([[[0.0, 0.0]], lumen * circle, circle])
    return points, section_triangles(sectors), np.repeat([True, False], [sectors, 2 * sectors])


def section_triangles(sectors: int) -> Indices:
    """Return a section's triangles (3 sectors, 3): the lumen's, then the wall's.

    Their corners are places in a ring, ordered as centre, inner, outer.
    """
    k = np.arange(sectors)
    inner, inner_next = 1 + k, 1 + (k + 1) % sectors
    outer, outer_next = inner + sectors, inner_next + sectors
    triangles = (
        (np.zeros_like(k), inner, inner_next),
        (inner, outer, outer_next),
        (inner, outer_next, inner_next),
    )
    return np.concatenate([np.stack(t, axis=1) for t in triangles]).astype(np.int32)


def _prism_tets(triangles: Indices, n_disc: int) -> Indices:
    """Divide the prism over each triangle into three tetrahedra, (3 n_triangle, 4).

    The diagonal of each quadrilateral starts at its smaller index, so neighbours agree. Source:
    Dompierre et al., "How to subdivide pyramids, prisms and hexahedra into tetrahedra", 1999.
    """
    out = []
    for triangle in triangles:
        shift = int(np.argmin(triangle))
        a, b, c = np.roll(triangle, -shift)
        A, B, C = a + n_disc, b + n_disc, c + n_disc
        if b < c:
            out += [(a, b, c, C), (a, b, C, B), (a, B, C, A)]
        else:
            out += [(a, b, c, B), (a, c, C, B), (a, B, C, A)]
    return np.array(out, dtype=np.int32)


def ring_radii_m(positions: NDArray[np.floating], rings: Indices) -> Array:
    """Return (n_ring,) the outer vertices' mean distance from the centre."""
    outer = positions[rings[:, (rings.shape[1] + 1) // 2 :]]
    spokes = outer - positions[rings[:, :1]]
    return np.sqrt(np.vecdot(spokes, spokes)).mean(axis=1, dtype=float)
