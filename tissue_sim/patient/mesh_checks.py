"""Is a mesh fit to be simulated? Refused are broken elements and parts that nothing holds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.mechanics.topology import components
from tissue_sim.patient.mesher import Indices, signed_volumes

if TYPE_CHECKING:
    from tissue_sim.patient.organ import Organ

MIN_SHAPE = 1.0e-5  # volume over longest edge cubed, assumed; a regular tetrahedron has 0.118


def require_sound_elements(vertices: Array, tets: Indices, part: str = "tissue") -> None:
    """Refuse a mesh that no element law can be evaluated on.

    Args:
        vertices: (n_vertex, 3), m.
        tets: (n_tet, 4).
        part: what the message calls it.

    Raises:
        ValueError: a vertex is not finite or belongs to no element, an index is out of range, or
            an element is inverted or flat; the first of them is named.
    """
    n = len(vertices)
    finite = np.isfinite(vertices).all(axis=1)
    if not finite.all():
        k = int(np.argmin(finite))
        raise ValueError(f"mesh of the {part}: vertex {k} is at {vertices[k]}: not finite")
    _require_indices("tets", tets, n, part)
    unused = np.bincount(tets.ravel(), minlength=n) == 0
    if unused.any():
        raise ValueError(f"mesh of the {part}: vertex {np.argmax(unused)} belongs to no element")
    corners = vertices[tets]
    edges = np.linalg.norm(corners[:, [0, 0, 0, 1, 1, 2]] - corners[:, [1, 2, 3, 2, 3, 3]], axis=-1)
    shape = signed_volumes(vertices, tets) / np.maximum(edges.max(axis=1), 1e-12) ** 3
    if shape.min() < MIN_SHAPE:
        k = int(np.argmin(shape))
        fault = "flat" if shape[k] > -MIN_SHAPE else "inverted"
        raise ValueError(
            f"mesh of the {part}: element {k} (vertices {tets[k].tolist()}) is {fault}: its volume "
            f"over its longest edge cubed is {shape[k]:.2g}, allowed from {MIN_SHAPE:g}"
        )


def require_sound_organ(organ: Organ) -> None:
    """Refuse an organ with unsound elements, or of which a part hangs in the air.

    Parts are joined by ties and strands. One body alone may be free; of several, each must be
    joined to the rest, or held at fixed vertices or at the liver bed.

    Raises:
        ValueError: naming the element or the part.
    """
    require_sound_elements(organ.vertices, organ.tets)
    n = len(organ.vertices)
    for name in ("tie_vertex", "tie_corners", "bed_vertices", "remnants"):
        _require_indices(name, getattr(organ, name), n, "tissue")
    ties = np.column_stack([organ.tie_vertex, organ.tie_corners[:, 0]]).reshape(-1, 2)
    joints = np.concatenate([ties, organ.remnants]).astype(np.int32)
    label = components(n, np.concatenate([organ.tets, joints[:, [0, 1, 1, 1]]]))
    held = set(label[organ.fixed].tolist()) | set(label[organ.bed_vertices].tolist())
    loose = set(label.tolist()) - held
    if loose and len(set(label.tolist())) > 1:
        part = np.flatnonzero(label == min(loose))
        raise ValueError(
            f"mesh of the tissue: the part of {len(part)} vertices around vertex {part[0]} is "
            "neither held nor joined to the rest"
        )


def _require_indices(name: str, indices: Indices, n: int, part: str) -> None:
    wrong = (indices < 0) | (indices >= n)
    if wrong.any():
        row = int(np.argwhere(wrong)[0][0])
        raise ValueError(
            f"mesh of the {part}: {name}[{row}] = {np.asarray(indices[row]).tolist()} is out of "
            f"range: there are {n} vertices"
        )
