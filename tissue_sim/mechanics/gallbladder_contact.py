"""Compute contact of tubes with the gallbladder.

Each ring of a tube is a ball outside the gallbladder's skin.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays
from tissue_sim.mechanics.sides import is_severed
from tissue_sim.mechanics.touch import add_vertex_term
from tissue_sim.mechanics.tube_contact import ring_centre

wp.set_module_options({"enable_backward": False})

RING_STIFFNESS = wp.constant(1000.0)  # N/m per ring, assumed: its corners against a tube, together
# Tube radii, assumed. A deeper ring has no contact: its nearest face could alternate between both
# sides, and the ring would not come to rest.
DEEPEST = wp.constant(0.5)


@wp.struct
class SkinPoint:
    """The point of the skin that is nearest to a ring's centre.

    Attributes:
        face: Triangle of the point; -1 if no triangle is near.
        share: Weights of the triangle's corners.
        normal: Outward normal of the triangle.
        height: Height of the centre above the triangle, m; below 0 inside.
    """

    face: int
    share: wp.vec3
    normal: wp.vec3
    height: float


@wp.func
def nearest_share(p: wp.vec3, a: wp.vec3, b: wp.vec3, c: wp.vec3):
    """Return the weights of a triangle's corners at the triangle's point nearest to p.

    Source: Ericson, "Real-time collision detection", 2005, section 5.1.5.
    """
    ab, ac, ap = b - a, c - a, p - a
    d1, d2 = wp.dot(ab, ap), wp.dot(ac, ap)
    if d1 <= 0.0 and d2 <= 0.0:
        return wp.vec3(1.0, 0.0, 0.0)
    bp = p - b
    d3, d4 = wp.dot(ab, bp), wp.dot(ac, bp)
    if d3 >= 0.0 and d4 <= d3:
        return wp.vec3(0.0, 1.0, 0.0)
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v = d1 / (d1 - d3)
        return wp.vec3(1.0 - v, v, 0.0)
    cp = p - c
    d5, d6 = wp.dot(ab, cp), wp.dot(ac, cp)
    if d6 >= 0.0 and d5 <= d6:
        return wp.vec3(0.0, 0.0, 1.0)
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        w = d2 / (d2 - d6)
        return wp.vec3(1.0 - w, 0.0, w)
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and (d4 - d3) >= 0.0 and (d5 - d6) >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return wp.vec3(0.0, 1.0 - w, w)
    return wp.vec3(va, vb, vc) / (va + vb + vc)


@wp.func
def above_face(t: TissueArrays, x: wp.array(dtype=wp.vec3), b: int, face: int, p: wp.vec3):
    """Return the point of a triangle of the skin, at positions x, that is nearest to p."""
    r = SkinPoint()
    f = t.skin[b, face]
    a = x[f[0]]
    u = x[f[1]] - a
    v = x[f[2]] - a
    outward = wp.normalize(wp.cross(u, v))
    r.face = face
    r.share = nearest_share(p, a, x[f[1]], x[f[2]])
    off = p - a - u * r.share[1] - v * r.share[2]
    distance = wp.length(off)
    side = wp.where(wp.dot(p - a, outward) < 0.0, -1.0, 1.0)
    r.height = side * distance
    r.normal = wp.where(distance > 1.0e-6, off * (side / (distance + 1.0e-12)), outward)
    return r


@wp.func
def find_near_skin(t: TissueArrays, b: int):
    """List the triangles of the skin that are near any ring that can touch the skin.

    A hole in the wall has no skin.
    """
    low = wp.vec3(1.0e9)
    high = wp.vec3(-1.0e9)
    for tube in range(t.n_colliding[b]):
        reach = wp.vec3(2.0 * t.tube_radius[b, tube])
        for r in range(t.n_ring[b, tube]):
            if t.ring_beside_sac[b, tube, r] != 0:
                low = wp.min(
                    low, wp.min(t.ring_centre[b, tube, r], t.ring_centre_above[b, tube, r]) - reach
                )
                high = wp.max(
                    high, wp.max(t.ring_centre[b, tube, r], t.ring_centre_above[b, tube, r]) + reach
                )
    n = int(0)
    for k in range(t.n_skin[b]):
        f = t.skin[b, k]
        p = t.position[b, f[0]]
        q = t.position[b, f[1]]
        s = t.position[b, f[2]]
        top = wp.max(wp.max(p, q), s)
        bottom = wp.min(wp.min(p, q), s)
        whole = t.tet_alive[b, t.skin_tet[b, k]] != 0
        if (
            whole
            and bottom[0] < high[0] and top[0] > low[0]
            and bottom[1] < high[1] and top[1] > low[1]
            and bottom[2] < high[2] and top[2] > low[2]
        ):  # fmt: skip
            t.skin_near[b, n] = k
            t.skin_middle[b, n] = (p + q + s) / 3.0
            t.skin_reach[b, n] = wp.length(top - bottom)
            n = n + 1
    t.n_skin_near[b] = n


@wp.func
def nearest_skin(t: TissueArrays, b: int, p: wp.vec3, reach: float):
    """Return the point of the listed skin that is nearest to p; none if no point is in reach."""
    best = SkinPoint()
    best.face = -1
    best.height = reach
    for n in range(t.n_skin_near[b]):
        off = p - t.skin_middle[b, n]
        far = t.skin_reach[b, n] + wp.abs(best.height)
        if wp.dot(off, off) < far * far:
            now = above_face(t, t.position[b], b, t.skin_near[b, n], p)
            if wp.abs(now.height) < wp.abs(best.height):
                best = now
    return best


@wp.func
def push_out_of_sac(
    t: TissueArrays, b: int, tube: int, r: int, ring: wp.array4d(dtype=int), centre: wp.vec3
):
    """Push a ring out of the sac; the skin's triangle carries the reaction.

    A contact that exists at the start of the step lasts to its end, as on the liver bed.
    """
    radius = t.tube_radius[b, tube]
    at = nearest_skin(t, b, centre, 2.0 * radius)
    if at.face < 0 or at.height < -DEEPEST * radius:
        return
    touches = at.height < radius
    if not touches:
        before = ring_centre(ring, t.previous, b, tube, r)
        touches = above_face(t, t.previous[b], b, at.face, before).height < radius
    if touches:
        f = at.normal * (RING_STIFFNESS * (radius - at.height))
        # twice the diagonal, as between tubes
        K = wp.outer(at.normal, at.normal) * (2.0 * RING_STIFFNESS)
        share = 1.0 / float(ring.shape[3])
        for k in range(ring.shape[3]):
            add_vertex_term(t, b, ring[b, tube, r, k], f * share, K * share)
        face = t.skin[b, at.face]
        for k in range(3):
            add_vertex_term(t, b, face[k], f * (-at.share[k]), K * at.share[k])


@wp.func
def push_ring_out_of_sac(t: TissueArrays, b: int, tube: int, r: int):
    """Push a ring, on both sides of a cut, out of the sac.

    Loose pieces are left out. A loose piece weighs milligrams, so the stiff contact would dominate
    the solver's equations and move the piece erratically.
    """
    if t.ring_beside_sac[b, tube, r] != 0:
        if t.held[b, t.ring[b, tube, r, 0]] != 0:
            push_out_of_sac(t, b, tube, r, t.ring, t.ring_centre[b, tube, r])
        if is_severed(t, b, tube, r) and t.held[b, t.ring_above[b, tube, r, 0]] != 0:
            push_out_of_sac(t, b, tube, r, t.ring_above, t.ring_centre_above[b, tube, r])


@wp.func
def add_sac_contact(t: TissueArrays, b: int):
    """Add the contact of the cystic tubes with the gallbladder."""
    find_near_skin(t, b)
    for tube in range(t.n_colliding[b]):
        for r in range(t.n_ring[b, tube]):
            push_ring_out_of_sac(t, b, tube, r)
