"""Check that a mesh can be simulated: refuse broken elements and indices out of range."""

from __future__ import annotations

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.patient.mesher import Indices, signed_volumes

MIN_SHAPE = 1.0e-5  # volume over longest edge cubed, assumed; a regular tetrahedron has 0.118


def require_sound_elements(vertices: Array, tets: Indices, part: str = "tissue") -> None:
    """Refuse a mesh on which the element law cannot be evaluated.

    Args:
        vertices: (n_vertex, 3), m.
        tets: (n_tet, 4).
        part: name of the mesh in the message.

    Raises:
        ValueError: a vertex is not finite or belongs to no element, an index is out of range, or an
            element is inverted or flat. The message names the first such error.
    """
    n = len(vertices)
    finite = np.isfinite(vertices).all(axis=1)
    if not finite.all():
        k = int(np.argmin(finite))
        raise ValueError(f"mesh of the {part}: vertex {k} is at {vertices[k]}, which is not finite")
    require_indices("tets", tets, n, part)
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
            f"over its longest edge cubed is {shape[k]:.2g}; the minimum is {MIN_SHAPE:g}"
        )


def require_indices(name: str, indices: Indices, n: int, part: str) -> None:
    """Raise a ValueError that names the first vertex index outside 0 to n - 1, if there is one."""
    wrong = (indices < 0) | (indices >= n)
    if wrong.any():
        row = int(np.argwhere(wrong)[0][0])
        raise ValueError(
            f"mesh of the {part}: {name}[{row}] = {np.asarray(indices[row]).tolist()} is out of "
            f"range: there are {n} vertices"
        )
