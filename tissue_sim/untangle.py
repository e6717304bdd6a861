"""How crushed tissue finds its way back: around an element turned inside out, the bulk gives way.

A violent squeeze can fold a tube's wall over. Such a fold is a stable equilibrium only because the
nearly incompressible elements around it would have to change volume on the way back; without
their bulk modulus it unfolds. So elements that share a vertex with an inverted one feel none
until that one has turned back. Under a clip nothing shall unfold.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.arrays import TissueArrays

wp.set_module_options({"enable_backward": False})


@wp.func
def inverted(t: TissueArrays, b: int, c: wp.vec4i):
    """Whether the tetrahedron of corners c is turned inside out."""
    origin = t.position[b, c[0]]
    along = t.position[b, c[1]] - origin
    return wp.dot(along, wp.cross(t.position[b, c[2]] - origin, t.position[b, c[3]] - origin)) < 0.0


@wp.func
def mark_tangled(t: TissueArrays, b: int, e: int):
    """Mark the corners of an inverted element, unless a clip holds one of them."""
    c = t.tet[b, e]
    if t.tet_alive[b, e] != 0 and inverted(t, b, c):
        clipped = t.covered[b, c[0]] + t.covered[b, c[1]] + t.covered[b, c[2]] + t.covered[b, c[3]]
        if clipped == 0:
            for k in range(4):
                t.tangled[b, c[k]] = 1


@wp.func
def ease(t: TissueArrays, b: int, e: int):
    """Give an element the lambda it feels: the material's, or none at a marked vertex."""
    c = t.tet[b, e]
    tangled = t.tangled[b, c[0]] + t.tangled[b, c[1]] + t.tangled[b, c[2]] + t.tangled[b, c[3]]
    t.lam[b, e] = wp.where(tangled == 0, t.bulk[b, e], 0.0)


@wp.func
def ease_bulk(t: TissueArrays, b: int):
    """Ease the bulk of all elements that need it."""
    for i in range(t.n_vertex[b]):
        t.tangled[b, i] = 0
    for e in range(t.n_tet[b]):
        mark_tangled(t, b, e)
    for e in range(t.n_tet[b]):
        ease(t, b, e)
