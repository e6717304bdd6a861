"""How crushed tissue finds its way back: around an element turned inside out, the bulk gives way.

A violent squeeze can fold a tube's wall over. Such a fold is a stable equilibrium only because the
nearly incompressible elements around it would have to change volume on the way back; without
their bulk modulus it unfolds. So elements that share a vertex with a folded one feel none. An
element counts as folded from when it is inverted until it has most of its volume back: to
give the bulk back as soon as it turns would fold it again, and so on for ever. Under a clip nothing
shall unfold.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays

wp.set_module_options({"enable_backward": False})


UNFOLDED = wp.constant(0.5)  # of an element's volume, assumed


@wp.func
def volume_share(t: TissueArrays, b: int, e: int):
    """An element's volume now over that at rest; negative when it is inside out."""
    c = t.tet[b, e]
    origin = t.position[b, c[0]]
    p = t.position[b, c[1]] - origin
    q = t.position[b, c[2]] - origin
    return wp.dot(p, wp.cross(q, t.position[b, c[3]] - origin)) / (6.0 * t.volume[b, e])


@wp.func
def mark_tangled(t: TissueArrays, b: int, e: int):
    """Mark the corners of a folded element, unless a clip holds one of them."""
    c = t.tet[b, e]
    clipped = t.covered[b, c[0]] + t.covered[b, c[1]] + t.covered[b, c[2]] + t.covered[b, c[3]]
    least = wp.where(t.folded[b, e] != 0, UNFOLDED, 0.0)
    t.folded[b, e] = 0
    if t.tet_alive[b, e] != 0 and clipped == 0 and volume_share(t, b, e) < least:
        t.folded[b, e] = 1
        for k in range(4):
            t.tangled[b, c[k]] = 1


@wp.func
def ease(t: TissueArrays, b: int, e: int):
    """Give an element the lambda it feels: the material's, or none at a marked vertex."""
    c = t.tet[b, e]
    tangled = t.tangled[b, c[0]] + t.tangled[b, c[1]] + t.tangled[b, c[2]] + t.tangled[b, c[3]]
    lam = wp.where(tangled == 0, t.bulk[b, e], 0.0)
    if lam != t.lam[b, e]:
        t.lam[b, e] = lam
        t.stiffness_holds[b] = 0


@wp.func
def ease_bulk(t: TissueArrays, b: int):
    """Ease the bulk of all elements that need it."""
    for i in range(t.n_vertex[b]):
        t.tangled[b, i] = 0
    for e in range(t.n_tet[b]):
        mark_tangled(t, b, e)
    for e in range(t.n_tet[b]):
        ease(t, b, e)
