"""Find the part of the gallbladder's wall between a clip's legs, and the springs that press it.

The wall's mesh is coarse: rings are 2.5 mm apart at the neck. As on a tube, the legs' width decides
which vertices they hold. The legs may close on the wall between two rings, or their width may cover
vertices on one side only. Then they hold the whole part of the nearest ring between them. A fold
of the wall may bring vertices of different rings together, so that springs join whatever lies
opposite.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.patient.organ import Organ
from tissue_sim.patient.walls import n_sectors

Squeeze = tuple[str, float, float]  # layer, stiffness (N/m), rest over the two walls' thickness
Spring = tuple[int, int, float, float]  # vertices, rest (m), stiffness (N/m)


def wall_under(
    organ: Organ, local: Array, between: NDArray[np.bool_], width_m: float
) -> NDArray[np.bool_]:
    """Return (n_ring, 1 + 2 n_sectors) which vertices of the gallbladder the legs hold.

    Args:
        organ: The organ.
        local: (n_vertex, 3) positions in the clip's frame, m: x along the tube, y across the legs.
        between: (n_vertex,), whether a vertex lies between the legs, at any place along the tube.
        width_m: Width of the legs.
    """
    x, y, _ = np.moveaxis(local[organ.sac_rings], -1, 0)
    pressed = between[organ.sac_rings]
    under = pressed & (np.abs(x) <= 0.5 * width_m)
    upper = y[:, 1:][under[:, 1:]] > 0.0  # of the wall, without the rings' centres
    if upper.any() and not upper.all():
        return under
    if under.any():
        nearest = np.argmax(under.sum(axis=1))
        under[nearest] = pressed[nearest]
        return under
    some = np.flatnonzero(pressed.any(axis=1))
    middle = np.array([x[ring, pressed[ring]].mean() for ring in some])
    for k in np.flatnonzero(np.diff(some) == 1):
        if middle[k] * middle[k + 1] < 0.0:
            nearest = some[k + np.argmin(np.abs(middle[k : k + 2]))]
            under[nearest] = pressed[nearest]
    return under


def wall_springs(
    organ: Organ, local: Array, under: NDArray[np.bool_], squeezes: Sequence[Squeeze]
) -> list[Spring]:
    """Return springs across the legs' middle plane, from each vertex to the nearest opposite one.

    Args:
        organ: The organ.
        local: (n_vertex, 3) positions in the clip's frame, m.
        under: What `wall_under` returned.
        squeezes: Layers of the wall with stiffness and rest, as on a tube.
    """
    n = n_sectors(organ)
    layers = {"inner": slice(1, 1 + n), "outer": slice(1 + n, None)}
    springs = []
    for name, stiffness, share in squeezes:
        held = organ.sac_rings[:, layers[name]][under[:, layers[name]]]
        above = local[held, 1] > 0.0
        for i, j in _facing(local, held[above], held[~above]):
            walls_m = _thickness_m(organ, i) + _thickness_m(organ, j)
            springs.append((i, j, share * walls_m, stiffness))
    return springs


def rings_of(organ: Organ, springs: Sequence[Spring]) -> tuple[int, ...]:
    """Return the gallbladder's rings that springs squeeze."""
    ends = [vertex for i, j, _, _ in springs for vertex in (i, j)]
    return tuple(np.flatnonzero(np.isin(organ.sac_rings, ends).any(axis=1)).tolist())


def wall_spacing_m(organ: Organ, rings: Sequence[int]) -> float:
    """Return the length of wall that the first of the rings represents at rest; 0 without rings."""
    if not rings:
        return 0.0
    first = min(rings[0], len(organ.sac_rings) - 2)
    ends = organ.vertices[organ.sac_rings[[first, first + 1], 0]]
    return float(np.linalg.norm(ends[1] - ends[0]))


def _facing(
    local: Array, upper: NDArray[np.integer], lower: NDArray[np.integer]
) -> list[tuple[int, int]]:
    """Pair each vertex of the larger half with the nearest of the other half, seen across."""
    if not (len(upper) and len(lower)):
        return []
    more, fewer = (upper, lower) if len(upper) >= len(lower) else (lower, upper)
    apart = local[more][:, None, ::2] - local[fewer][None, :, ::2]
    nearest = fewer[np.argmin((apart**2).sum(axis=-1), axis=1)]
    return list(zip(more.tolist(), nearest.tolist(), strict=True))


def _thickness_m(organ: Organ, vertex: int) -> float:
    """Return the thickness of the meshed wall at a vertex of its inner or outer side, at rest."""
    ring, place = np.argwhere(organ.sac_rings == vertex)[0]
    n = n_sectors(organ)
    inner, outer = organ.sac_rings[ring, [1 + (place - 1) % n, 1 + n + (place - 1) % n]]
    return float(np.linalg.norm(organ.vertices[outer] - organ.vertices[inner]))
