"""Let instruments catch strands: a caught strand runs over one point of the instrument.

A strand is a straight spring between two vertices until an instrument touches it or sweeps over it.
Then both legs of the strand end at the contact point on the instrument's surface. They carry the
same tension, k (l_0 + l_1 - L), because a wet strand slides along itself. The contact point slides
over the surface beyond its friction, and off the tip or an edge. A strand that would leave the
surface is straight again. A clip's springs are too strong to break, and are no strands.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays, ToolShapes
from tissue_sim.mechanics.sides import REACH, link_origin, to_link_frame
from tissue_sim.mechanics.touch import Box, along_segment, box_of_arm

wp.set_module_options({"enable_backward": False})

BREAKABLE = wp.constant(1000.0)  # N; above any strand's strength, below a clip's spring's
SEARCHES = wp.constant(6)  # assumed: steps of the search for the nearest points
ROOT = wp.constant(0.1)  # assumed: a strand is caught away from its ends, as a share of its length
LEAST = wp.constant(2.0e-4)  # m; a shorter leg has no direction


@wp.struct
class Bend:
    """A caught strand: contact point, unit vectors to its ends, lengths (m) and tension (N)."""

    at: wp.vec3
    to_first: wp.vec3
    to_second: wp.vec3
    first: float
    second: float
    tension: float


@wp.func
def is_strand(t: TissueArrays, b: int, n: int):
    return t.link_stiffness[b, n] > 0.0 and t.link_strength[b, n] < BREAKABLE


@wp.func
def nearest_on_patch(s: ToolShapes, b: int, c: int, x: wp.vec3):
    """Return the point of a patch's rectangle that is nearest to x."""
    u = s.b[b, c] - s.a[b, c]
    w = s.half_width[b, c]
    p = x - s.a[b, c]
    across = wp.clamp(wp.dot(p, w) / (wp.dot(w, w) + 1.0e-12), -1.0, 1.0)
    return s.a[b, c] + u * along_segment(p, u) + w * across


@wp.func
def nearest_share(s: ToolShapes, b: int, c: int, p: wp.vec3, q: wp.vec3):
    """Return the share of the segment from p to q that is nearest to a patch.

    Projecting in turn on two convex bodies leads to their nearest points.
    """
    share = float(0.5)
    for _ in range(SEARCHES):
        y = nearest_on_patch(s, b, c, p + (q - p) * share)
        share = along_segment(y - p, q - p)
    return share


@wp.func
def bend(t: TissueArrays, s: ToolShapes, b: int, n: int, first: wp.vec3, second: wp.vec3):
    """Return a caught strand between its ends."""
    r = Bend()
    T_world_link = s.T_world_link[b, t.strand_shape[b, n]]
    r.at = wp.transform_point(T_world_link, t.strand_point[b, n])
    r.first = wp.max(wp.length(first - r.at), LEAST)
    r.second = wp.max(wp.length(second - r.at), LEAST)
    r.to_first = (first - r.at) / r.first
    r.to_second = (second - r.at) / r.second
    longer = r.first + r.second - t.link_rest[b, n]
    r.tension = t.link_stiffness[b, n] * wp.max(longer, 0.0)
    return r


@wp.func
def meets(box: Box, p: wp.vec3, q: wp.vec3):
    """Return whether the box around a segment meets a tool's box."""
    gap = wp.max(wp.min(p, q) - box.high, box.low - wp.max(p, q))
    return wp.max(gap) < 0.0


@wp.func
def offset_before(t: TissueArrays, s: ToolShapes, b: int, n: int, c: int):
    """Return the offset of a strand from a shape as the step began, turned with the shape."""
    before = s.T_world_link_before[b, c]
    T = s.T_world_link[b, c]
    p = wp.transform_point(T, to_link_frame(before, t.previous[b, t.link[b, n][0]]))
    q = wp.transform_point(T, to_link_frame(before, t.previous[b, t.link[b, n][1]]))
    x = p + (q - p) * nearest_share(s, b, c, p, q)
    return x - nearest_on_patch(s, b, c, x)


@wp.func
def catch_by(t: TissueArrays, s: ToolShapes, b: int, n: int, c: int, p: wp.vec3, q: wp.vec3):
    """Let shape c catch the strand from p to q that it touches, or swept over in this step."""
    share = nearest_share(s, b, c, p, q)
    x = p + (q - p) * share
    y = nearest_on_patch(s, b, c, x)
    out = x - y
    if wp.length(out) < REACH and share > ROOT and share < 1.0 - ROOT:
        out0 = offset_before(t, s, b, n, c)
        swept = wp.dot(out, out0) < -0.5 * wp.length(out) * wp.length(out0)
        if swept or wp.length(out) < s.radius[b, c]:
            T = s.T_world_link[b, c]
            normal = wp.normalize(wp.where(wp.length_sq(out0) > 0.0, out0, out))
            t.strand_shape[b, n] = c
            t.strand_point[b, n] = to_link_frame(T, y + normal * s.radius[b, c])
            t.strand_normal[b, n] = to_link_frame(T, link_origin(T) + normal)


@wp.func
def follow(t: TissueArrays, s: ToolShapes, b: int, n: int, p: wp.vec3, q: wp.vec3):
    """Let a caught strand slide over the surface, or leave it."""
    c = t.strand_shape[b, n]
    T = s.T_world_link[b, c]
    r = bend(t, s, b, n, p, q)
    normal = wp.transform_vector(T, t.strand_normal[b, n])
    pull = r.to_first + r.to_second
    bearing = -wp.dot(pull, normal)
    aside = pull + normal * bearing
    u = s.b[b, c] - s.a[b, c]
    w = s.half_width[b, c]
    if wp.length_sq(w) == 0.0:  # round: the normal is kept, so the strand slides lengthwise only
        aside = u * (wp.dot(aside, u) / wp.dot(u, u))
    excess = wp.length(aside) - s.friction[b, c] * bearing
    at = r.at
    if excess > 0.0:
        at = at + wp.normalize(aside) * (excess / (1.0 / r.first + 1.0 / r.second))
    t.strand_point[b, n] = to_link_frame(T, at)
    along = wp.dot(at - s.a[b, c], u) / (wp.dot(u, u) + 1.0e-12)
    across = wp.dot(at - s.a[b, c], w) / (wp.dot(w, w) + 1.0e-12)
    off = along * wp.length(u) > wp.length(u) + s.radius[b, c]
    off = off or wp.abs(across) * wp.length(w) > wp.length(w) + s.radius[b, c]
    if bearing <= 0.0 or off:
        t.strand_shape[b, n] = -1


@wp.func
def add_bend(t: TissueArrays, s: ToolShapes, b: int, n: int, p: wp.vec3, q: wp.vec3):
    """Add forces and stiffness of a caught strand to its two ends."""
    r = bend(t, s, b, n, p, q)
    if r.tension > 0.0:
        k = t.link_stiffness[b, n]
        I = wp.identity(n=3, dtype=float)
        wp.atomic_sub(t.force, b, t.link[b, n][0], r.to_first * r.tension)
        wp.atomic_sub(t.force, b, t.link[b, n][1], r.to_second * r.tension)
        A = wp.outer(r.to_first, r.to_first)
        B = wp.outer(r.to_second, r.to_second)
        C = wp.outer(r.to_second, r.to_first) * k
        wp.atomic_add(t.block, b, t.link_slot[b, n, 0], A * k + (I - A) * (r.tension / r.first))
        wp.atomic_add(t.block, b, t.link_slot[b, n, 1], C)
        wp.atomic_add(t.block, b, t.link_slot[b, n, 2], wp.transpose(C))
        wp.atomic_add(t.block, b, t.link_slot[b, n, 3], B * k + (I - B) * (r.tension / r.second))


@wp.func
def add_strands(t: TissueArrays, s: ToolShapes, b: int):
    """Catch and release strands, and add the caught ones; `springs` adds the straight ones."""
    left = box_of_arm(s, b, 0)
    right = box_of_arm(s, b, 1)
    for n in range(t.link_stiffness.shape[1]):
        if is_strand(t, b, n):
            p = t.position[b, t.link[b, n][0]]
            q = t.position[b, t.link[b, n][1]]
            if t.strand_shape[b, n] >= 0:
                follow(t, s, b, n, p, q)
            near_left = meets(left, p, q)
            near_right = meets(right, p, q)
            for c in range(8):
                near = wp.where(c < 4, near_left, near_right)
                if near and t.strand_shape[b, n] < 0:
                    catch_by(t, s, b, n, c, p, q)
            if t.strand_shape[b, n] >= 0:
                add_bend(t, s, b, n, p, q)


@wp.func
def break_strands(t: TissueArrays, s: ToolShapes, b: int):
    """Break caught strands that carry more than their strength."""
    for n in range(t.link_stiffness.shape[1]):
        if is_strand(t, b, n) and t.strand_shape[b, n] >= 0:
            p = t.position[b, t.link[b, n][0]]
            q = t.position[b, t.link[b, n][1]]
            if bend(t, s, b, n, p, q).tension > t.link_strength[b, n]:
                t.link_stiffness[b, n] = 0.0
                t.strand_shape[b, n] = -1


@wp.func
def react_to_strands(t: TissueArrays, s: ToolShapes, b: int):
    """Add the pull of caught strands to the instruments, at the end of the step.

    Call this after `touch.react_on_tools`, which clears the sums.
    """
    for n in range(t.link_stiffness.shape[1]):
        if is_strand(t, b, n) and t.strand_shape[b, n] >= 0:
            c = t.strand_shape[b, n]
            p = t.position[b, t.link[b, n][0]]
            q = t.position[b, t.link[b, n][1]]
            r = bend(t, s, b, n, p, q)
            f = (r.to_first + r.to_second) * r.tension
            wp.atomic_add(s.force, b, c, f)
            wp.atomic_add(s.torque, b, c, wp.cross(r.at - link_origin(s.T_world_link[b, c]), f))
