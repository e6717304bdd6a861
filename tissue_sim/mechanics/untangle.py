"""Untangle crushed tissue: stiffen an inverted element, and remove the bulk modulus around it.

A violent squeeze can fold a tube's wall over. Such a fold is a stable equilibrium, because the
nearly incompressible elements around it would have to change volume to unfold. Without their bulk
modulus, the fold opens. So elements that share a vertex with a folded element lose their bulk
modulus. An element counts as folded from its inversion until it has regained most of its volume. If
the bulk modulus returned as soon as the element turns, the element would fold again and again.
The soft filling beside a clip that holds a part of the gallbladder's wall would stay folded,
because the wall is much stiffer. A dent in a wall would stay, because its folded elements are no
stiffer than those around it. A folded element therefore has a multiple of its own shear modulus,
and at least a wall's. It keeps this modulus until it has regained nearly all of its volume.
All this holds for nearly incompressible elements. A lumen's elements are soft and compressible:
they may lose their volume for good, and the sound wall around them opens them. Nothing is untangled
under a clip.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays

wp.set_module_options({"enable_backward": False})


UNFOLDED = wp.constant(0.5)  # assumed: share of an element's volume
SOUND = wp.constant(0.9)  # likewise, from which a stiffened element is soft again; assumed
FOLDED_PA = wp.constant(100.0e3)  # least shear modulus of a folded element: a wall's, assumed
FOLDED_TIMES = wp.constant(4.0)  # shear modulus of a folded element, over its material's; assumed


@wp.func
def volume_share(t: TissueArrays, b: int, e: int):
    """Return an element's current volume over its rest volume; negative when inverted."""
    c = t.tet[b, e]
    origin = t.position[b, c[0]]
    p = t.position[b, c[1]] - origin
    q = t.position[b, c[2]] - origin
    return wp.dot(p, wp.cross(q, t.position[b, c[3]] - origin)) / (6.0 * t.volume[b, e])


@wp.func
def mark_tangled(t: TissueArrays, b: int, e: int):
    """Mark a folded element and its corners, if it is nearly incompressible and no clip holds it.

    Return whether the element is folded, was folded before, or is stiffened.
    """
    was_folded = t.folded[b, e] != 0
    t.folded[b, e] = 0
    keeps_volume = t.bulk[b, e] > t.shear[b, e]
    if keeps_volume and volume_share(t, b, e) < wp.where(was_folded, UNFOLDED, 0.0):
        c = t.tet[b, e]
        clipped = t.covered[b, c[0]] + t.covered[b, c[1]] + t.covered[b, c[2]] + t.covered[b, c[3]]
        if t.tet_alive[b, e] != 0 and clipped == 0:
            t.folded[b, e] = 1
            for k in range(4):
                t.tangled[b, c[k]] = 1
    return was_folded or t.folded[b, e] != 0 or t.mu[b, e] > t.shear[b, e]


@wp.func
def ease(t: TissueArrays, b: int, e: int):
    """Set an element's current moduli: lambda is zero at a marked vertex, mu high if stiffened."""
    c = t.tet[b, e]
    tangled = t.tangled[b, c[0]] + t.tangled[b, c[1]] + t.tangled[b, c[2]] + t.tangled[b, c[3]]
    lam = wp.where(tangled == 0, t.bulk[b, e], 0.0)
    stays = t.mu[b, e] > t.shear[b, e] and volume_share(t, b, e) < SOUND
    stiff = t.folded[b, e] != 0 or stays
    mu = wp.where(stiff, wp.max(FOLDED_TIMES * t.shear[b, e], FOLDED_PA), t.shear[b, e])
    if lam != t.lam[b, e] or mu != t.mu[b, e]:
        t.lam[b, e] = lam
        t.mu[b, e] = mu
        t.stiffness_holds[b] = 0


@wp.func
def untangle(t: TissueArrays, b: int):
    """Update the current moduli of all elements."""
    for i in range(t.n_vertex[b]):
        t.tangled[b, i] = 0
    changes = int(0)
    for e in range(t.n_tet[b]):
        if mark_tangled(t, b, e):
            changes = 1
    if changes != 0:
        for e in range(t.n_tet[b]):
            ease(t, b, e)
