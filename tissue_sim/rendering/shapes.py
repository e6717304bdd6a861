"""Build simple surfaces to draw: grids, bent pipes, lofts and drops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array, unit
from tissue_sim.patient.mesher import section_axes
from tissue_sim.rendering.drawing import Surface


def sheet(points: Array, tile_m: float) -> Surface:
    """Build a surface through a grid of points (n, m, 3), visible from the side rows x columns."""
    rows, columns = np.gradient(points, axis=0), np.gradient(points, axis=1)
    length = [np.linalg.norm(d, axis=-1) for d in (rows, columns)]
    uv = np.stack([np.cumsum(length[0], axis=0), np.cumsum(length[1], axis=1)], axis=-1) / tile_m
    return Surface(
        points=points.reshape(-1, 3),
        normals=unit(np.cross(rows, columns).reshape(-1, 3)),
        triangles=grid(*points.shape[:2]),
        uv=uv.reshape(-1, 2),
    )


def pipe(line: Array, radius_m: float, tile_m: float, *, around: int = 18) -> Surface:
    """Build a round pipe along a line (n, 3)."""
    side, across = section_axes(line)
    angle = np.linspace(0.0, 2 * np.pi, around + 1)
    out = (
        np.cos(angle)[None, :, None] * side[:, None]
        + np.sin(angle)[None, :, None] * across[:, None]
    )
    surface = sheet(line[:, None] + radius_m * out, tile_m)
    return replace(surface, normals=out.reshape(-1, 3), triangles=surface.triangles[:, ::-1])


def threads(lines: Array, radii_m: Array, tile_m: float, *, around: int) -> Surface:
    """Build round threads along lines (n, k, 3), of radii (n, k) that may change along them."""
    n, k = radii_m.shape
    tangent = unit(np.gradient(lines, axis=1))
    side = unit(np.cross(tangent, np.where(np.abs(tangent[..., 2:]) < 0.9, [0, 0, 1], [1, 0, 0])))
    angle = np.linspace(0.0, 2 * np.pi, around + 1)[:, None]
    out = np.cos(angle) * side[:, :, None] + np.sin(angle) * np.cross(tangent, side)[:, :, None]
    starts = k * (around + 1) * np.arange(n)[:, None, None]
    along = np.linspace(0.0, np.linalg.norm(lines[:, -1] - lines[:, 0], axis=1), k).T / tile_m
    return Surface(
        points=(lines[:, :, None] + radii_m[..., None, None] * out).reshape(-1, 3),
        normals=out.reshape(-1, 3),
        triangles=(grid(k, around + 1)[:, ::-1] + starts).reshape(-1, 3),
        uv=np.stack(np.broadcast_arrays(along[..., None], 0.1 * angle[:, 0]), -1).reshape(-1, 2),
    )


def loft(rings: Array) -> Surface:
    """Build a closed flat-shaded body through rings (n, k, 3), counter-clockwise at the last."""
    n, k = rings.shape[:2]
    i, j = np.arange(n - 1)[:, None] * k, np.arange(k)
    a, b = (i + j).ravel(), (i + (j + 1) % k).ravel()
    fan = np.column_stack([np.zeros(k - 2, int), np.arange(1, k - 1), np.arange(2, k)])
    faces = np.concatenate(
        [
            np.stack([a, b, b + k], 1),
            np.stack([a, b + k, a + k], 1),
            fan[:, ::-1],
            fan + (n - 1) * k,
        ]
    )
    corners = rings.reshape(-1, 3)[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True) + 1e-20
    return Surface(
        points=corners.reshape(-1, 3),
        normals=np.repeat(normal, 3, axis=0),
        triangles=np.arange(3 * len(faces)).reshape(-1, 3),
        uv=np.zeros((3 * len(faces), 2)),
    )


def joined(surfaces: list[Surface]) -> Surface:
    """Join several surfaces into one."""
    starts = np.cumsum([0, *(len(s.points) for s in surfaces)])[:-1]
    return Surface(
        points=np.concatenate([s.points for s in surfaces]),
        normals=np.concatenate([s.normals for s in surfaces]),
        triangles=np.concatenate([s.triangles + n for s, n in zip(surfaces, starts, strict=True)]),
        uv=np.concatenate([s.uv for s in surfaces]),
    )


def drop(centre: Array, radii_m: Array) -> Surface:
    """Build an ellipsoid along the world's axes, of 12 sectors."""
    rows, columns = 9, 13
    polar, turn = np.meshgrid(
        np.linspace(0, np.pi, rows), np.linspace(0, 2 * np.pi, columns), indexing="ij"
    )
    ball = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], -1)
    return Surface(
        points=centre + radii_m * ball.reshape(-1, 3),
        normals=unit(ball.reshape(-1, 3) / radii_m),
        triangles=grid(rows, columns),
        uv=np.zeros((ball[..., 0].size, 2)),
    )


def grid(rows: int, columns: int) -> NDArray[np.int64]:
    """Return two triangles for each cell (n, 3), facing the side rows x columns."""
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    b, c, d = a + columns, a + columns + 1, a + 1
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
