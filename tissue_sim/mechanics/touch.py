"""Compute contact of tissue with instruments and with the liver bed.

Instruments are rounded patches (see `ToolShapes`). The normal force is a linear penalty. Friction
is Coulomb friction with elastic sticking. A touched vertex stores its sticking point on the shape,
and a tangential spring pulls the vertex back. The vertex slides when the spring force exceeds
friction times the normal force. A grasp is this same contact on both jaws.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays, ToolShapes
from tissue_sim.mechanics.sides import REACH, agree_on_sides, link_origin, to_link_frame

wp.set_module_options({"enable_backward": False})

# assumed: stiff compared with tissue (a node of a 300 kPa tube carries about 450 N/m), but soft
# enough for one linearisation per step
NORMAL_STIFFNESS = wp.constant(1500.0)  # N/m per vertex
STICK_STIFFNESS = wp.constant(500.0)  # N/m per vertex
BED_STIFFNESS = wp.constant(200.0)  # N/m per vertex
BED_THICKNESS = wp.constant(0.006)  # m; a deeper vertex is beside the liver, not inside


@wp.struct
class Touch:
    """Contact of a vertex with a patch: outward normal, depth (m, > 0 inside), stored side."""

    normal: wp.vec3
    depth: float
    side: float


@wp.func
def remembered_side(t: TissueArrays, b: int, i: int, c: int):
    """Return the stored side of finger c on which vertex i lies, 0 if no side is stored.

    A vertex between the jaws is between them for both fingers (rows 2 and 3 of an instrument's
    four). A vertex outside one finger need not be outside the other.
    """
    old = t.contact_shape[b, i]
    side = t.contact_side[b, i]
    if old == c:
        return side
    jaws = old >= 0 and c // 4 == old // 4 and c % 4 >= 2 and old % 4 >= 2
    if jaws and side > 0.0:
        return side
    return float(0.0)


@wp.func
def side_before(s: ToolShapes, b: int, c: int, before: wp.vec3, x: wp.vec3, inward: wp.vec3):
    """Return the side of finger c on which a point now at x was at `before`.

    If the finger swept over the point, the result is the opposite side, otherwise 0. A point that
    moved around the finger's rim was not swept over.
    """
    a = s.a[b, c]
    u = s.b[b, c] - a
    w = s.half_width[b, c]
    carried = wp.transform_point(
        s.T_world_link[b, c], to_link_frame(s.T_world_link_before[b, c], before)
    )
    start = wp.dot(carried - a, inward)
    end = wp.dot(x - a, inward)
    if start * end >= 0.0:
        return float(0.0)
    crossing = carried + (x - carried) * (start / (start - end)) - a
    along = wp.dot(crossing, u) / wp.dot(u, u)
    across = wp.dot(crossing, w) / wp.dot(w, w)
    if along < 0.0 or along > 1.0 or wp.abs(across) > 1.0:
        return float(0.0)
    return wp.sign(start)


@wp.func
def touch(s: ToolShapes, b: int, c: int, x: wp.vec3, before: wp.vec3, remembered: float):
    """Return the contact of point x with patch c.

    For a flat patch (a finger) the vertex's side is stored: +1 between the jaws, -1 outside. A
    vertex may be pressed through a finger's middle plane, or a finger may sweep over it in one
    step. The contact then pushes the vertex back to its stored side.
    """
    r = Touch()
    a = s.a[b, c]
    u = s.b[b, c] - a
    w = s.half_width[b, c]
    p = x - a
    along = wp.dot(p, u) / (wp.dot(u, u) + 1.0e-12)
    ww = wp.dot(w, w)
    across = float(0.0)
    if ww > 0.0:
        across = wp.clamp(wp.dot(p, w) / ww, -1.0, 1.0)
    q = p - u * wp.clamp(along, 0.0, 1.0) - w * across
    d = wp.length(q)
    r.normal = q / (d + 1.0e-9)
    r.depth = s.radius[b, c] - d
    inside = along > 0.0 and along < 1.0 and wp.abs(across) < 1.0
    if ww > 0.0 and inside and d < REACH:
        inward = wp.normalize(wp.cross(u, w))
        if c % 4 == 2:
            inward = -inward
        height = wp.dot(p, inward)
        r.side = remembered
        if r.side == 0.0:
            r.side = side_before(s, b, c, before, x, inward)
        if r.side == 0.0:
            r.side = wp.sign(height)
        r.normal = inward * r.side
        r.depth = s.radius[b, c] - r.side * height
    return r


@wp.func
def add_tool_contact(t: TissueArrays, s: ToolShapes, b: int, i: int):
    """Add the deepest contact of vertex i with the instruments."""
    x = t.position[b, i]
    best = int(-1)
    hit = Touch()
    old = t.contact_shape[b, i]
    for c in range(s.radius.shape[1]):
        now = touch(s, b, c, x, t.previous[b, i], remembered_side(t, b, i, c))
        stands = now.depth > 0.0
        if c == old and not stands:
            before = t.previous[b, i]
            stands = touch(s, b, c, before, before, remembered_side(t, b, i, c)).depth > 0.0
        if stands and now.depth < REACH and (best < 0 or now.depth > hit.depth):
            best = c
            hit = now
    f = wp.vec3()
    K = wp.mat33()
    if best >= 0:
        I = wp.identity(n=3, dtype=float)
        N = wp.outer(hit.normal, hit.normal)
        pressure = NORMAL_STIFFNESS * hit.depth
        f = hit.normal * pressure
        K = N * NORMAL_STIFFNESS
        T_world_link = s.T_world_link[b, best]
        if best != old:
            t.stick_point[b, i] = to_link_frame(T_world_link, x)
        slip = x - wp.transform_point(T_world_link, t.stick_point[b, i])
        slip = slip - hit.normal * wp.dot(slip, hit.normal)
        distance = wp.length(slip)
        k = STICK_STIFFNESS
        limit = s.friction[b, best] * wp.max(pressure, 0.0)
        if distance * k > limit:
            k = limit / distance
            anchor = x - slip * (limit / (distance * STICK_STIFFNESS))
            t.stick_point[b, i] = to_link_frame(T_world_link, anchor)
        f = f - slip * k
        K = K + (I - N) * k
    t.contact_shape[b, i] = best
    t.contact_side[b, i] = hit.side
    t.contact_force[b, i] = f
    t.contact_stiffness[b, i] = K
    add_vertex_term(t, b, i, f, K)


@wp.func
def along_segment(p: wp.vec3, u: wp.vec3):
    """Return the share of a segment u from the origin at which it is nearest to p."""
    return wp.clamp(wp.dot(p, u) / (wp.dot(u, u) + 1.0e-12), 0.0, 1.0)


@wp.func
def add_vertex_term(t: TissueArrays, b: int, i: int, f: wp.vec3, K: wp.mat33):
    wp.atomic_add(t.force, b, i, f)
    wp.atomic_add(t.block, b, t.row[b, i], K)


@wp.func
def add_bed_contact(t: TissueArrays, b: int, i: int):
    """Add the contact of vertex i with the liver bed's plane.

    A contact that exists at the start of the step lasts to its end, even if inertia alone would
    lift the vertex. Otherwise a resting body would alternate between contact and no contact.
    """
    p = t.position[b, i] - t.bed_point[b]
    height = wp.dot(p, t.bed_normal[b])
    before = wp.dot(t.previous[b, i] - t.bed_point[b], t.bed_normal[b])
    lowest = wp.min(height, before)
    on_bed = wp.dot(p, t.bed_along[b]) > t.bed_edge[b]
    if lowest < 0.0 and lowest > -BED_THICKNESS and on_bed:
        n = t.bed_normal[b]
        f = n * (-height * BED_STIFFNESS)
        wp.atomic_add(t.bed_force, b, f)
        add_vertex_term(t, b, i, f, wp.outer(n, n) * BED_STIFFNESS)


@wp.func
def touched_shapes(t: TissueArrays, b: int):
    """Return a bit for each shape that touches tissue."""
    touched = int(0)
    for i in range(t.n_vertex[b]):
        if t.contact_shape[b, i] >= 0:
            touched = touched | (1 << t.contact_shape[b, i])
    return touched


@wp.struct
class Box:
    """A box that contains every point which an arm's shapes can touch, world frame."""

    low: wp.vec3
    high: wp.vec3


@wp.func
def box_of_arm(s: ToolShapes, b: int, arm: int):
    box = Box()
    box.low = wp.vec3(1.0e9, 1.0e9, 1.0e9)
    box.high = -box.low
    for k in range(4):
        c = 4 * arm + k
        reach = wp.max(s.radius[b, c], REACH)
        w = s.half_width[b, c]
        margin = wp.vec3(wp.abs(w[0]) + reach, wp.abs(w[1]) + reach, wp.abs(w[2]) + reach)
        box.low = wp.min(box.low, wp.min(s.a[b, c], s.b[b, c]) - margin)
        box.high = wp.max(box.high, wp.max(s.a[b, c], s.b[b, c]) + margin)
    return box


@wp.func
def contains(box: Box, x: wp.vec3):
    inward = wp.min(x - box.low, box.high - x)
    return wp.min(inward) > 0.0


@wp.func
def add_surface_contact(t: TissueArrays, s: ToolShapes, b: int):
    """Add the contact of every surface vertex with instruments and liver bed."""
    t.bed_force[b] = wp.vec3()
    touched = touched_shapes(t, b)
    agree_on_sides(t, s, b, touched)
    left = box_of_arm(s, b, 0)
    right = box_of_arm(s, b, 1)
    for i in range(t.n_vertex[b]):
        if t.surface[b, i] != 0 and t.fixed[b, i] == 0:
            x = t.position[b, i]
            if t.contact_shape[b, i] >= 0 or contains(left, x) or contains(right, x):
                add_tool_contact(t, s, b, i)
            add_bed_contact(t, b, i)


@wp.func
def react(t: TissueArrays, s: ToolShapes, b: int, i: int):
    """Add the reaction of vertex i to the touched shape.

    The contact force at the end of the step is its linearisation at the solution, so tissue and
    instrument carry exactly opposite forces.
    """
    c = t.contact_shape[b, i]
    if c >= 0:
        f = t.contact_force[b, i] - t.contact_stiffness[b, i] * t.step[b, i]
        t.contact_force[b, i] = f
        arm = t.position[b, i] - link_origin(s.T_world_link[b, c])
        wp.atomic_sub(s.force, b, c, f)
        wp.atomic_sub(s.torque, b, c, wp.cross(arm, f))


@wp.func
def react_on_tools(t: TissueArrays, s: ToolShapes, b: int):
    """Sum the force (N) and the torque about the link's origin (N m) on each shape."""
    for c in range(s.radius.shape[1]):
        s.force[b, c] = wp.vec3()
        s.torque[b, c] = wp.vec3()
    for i in range(t.n_vertex[b]):
        react(t, s, b, i)
