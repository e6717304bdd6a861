"""Model a clip's squeeze: springs between the two halves of each ring under its legs.

The soft filling of a crushed lumen folds over. A few of its elements (2 kPa, assumed) are inverted
while the clip is closed, and recover when it detaches. The walls are never inverted.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.structures.tubes import Tubes

# Layer of a ring, stiffness of a spring (N/m), rest distance over tube radius. Assumed: so stiff
# that the lumen closes (`tissue_sim/verification/clip_closure.py`), the walls pressed flat.
SQUEEZES = (
    ("inner", 15000.0, 0.002),
    ("outer", 5000.0, 0.30),
)
UNBREAKABLE_N = 1.0e9  # no pull comes near it: a clip gives way by its lock and by friction

Spring = tuple[int, int, float, float]  # vertices, rest (m), stiffness (N/m)


def springs_across(
    ring: NDArray[np.int32], held: NDArray[np.bool_], local: Array, radius_m: float
) -> list[Spring]:
    """Return the springs of one ring, between its upper and lower half.

    Args:
        ring: (1 + 2 n,) vertices: centre, inner, outer.
        held: whether each vertex lies between the legs.
        local: (n_vertex, 3) positions in the clip's frame, m.
        radius_m: radius of the tube.
    """
    if not held.any():
        return []
    n = (len(ring) - 1) // 2
    middle = float(np.median(local[ring[held], 1]))
    layers = {"inner": slice(1, 1 + n), "outer": slice(1 + n, None)}
    springs = []
    for name, stiffness, rest in SQUEEZES:
        vertices = ring[layers[name]][held[layers[name]]]
        vertices = vertices[np.argsort(local[vertices, 2])]
        above = local[vertices, 1] > middle
        upper, lower = vertices[above], vertices[~above]
        for k in range(max(len(upper), len(lower)) if len(upper) and len(lower) else 0):
            i, j = (int(half[min(k, len(half) - 1)]) for half in (upper, lower))
            springs.append((i, j, rest * radius_m, stiffness))
    return springs


def squeeze(tubes: Tubes, springs: list[Spring], vertices: list[int]) -> tuple[int, ...]:
    """Cover vertices with the legs and press them together with springs; return their rows."""
    tubes.tissue.host("covered")[tubes.b, vertices] += 1
    if not springs:
        return ()
    table = np.array(springs)
    rows = tubes.tissue.add_links(
        tubes.b,
        table[:, :2].astype(int),
        rest_m=table[:, 2],
        stiffness=table[:, 3],
        strength_n=UNBREAKABLE_N,
    )
    tubes.tissue.rewire(tubes.b)
    return tuple(int(r) for r in rows)


def springs_in(tubes: Tubes, rows: tuple[int, ...]) -> list[Spring]:
    """Return the springs in these rows."""
    host, at = tubes.tissue.host, (tubes.b, list(rows))
    columns = (host("link")[at].tolist(), host("link_rest")[at], host("link_stiffness")[at])
    return [(i, j, float(L), float(k)) for (i, j), L, k in zip(*columns, strict=True)]


def release(tubes: Tubes, rows: tuple[int, ...], vertices: tuple[int, ...]) -> None:
    """Undo `squeeze`; vertices that another clip also covers stay covered."""
    tubes.tissue.host("link_stiffness")[tubes.b, list(rows)] = 0.0
    tubes.tissue.host("covered")[tubes.b, list(vertices)] -= 1
    tubes.tissue.rewire(tubes.b)


def tension_n(tubes: Tubes, rows: tuple[int, ...]) -> float:
    """Return the sum of the springs' tensions, N."""
    host, at = tubes.tissue.host, (tubes.b, list(rows))
    x = tubes.tissue.positions(tubes.b)[host("link")[at]].astype(float)
    stretch = np.linalg.norm(x[:, 1] - x[:, 0], axis=1) - host("link_rest")[at]
    return float((host("link_stiffness")[at] * np.maximum(stretch, 0.0)).sum())
