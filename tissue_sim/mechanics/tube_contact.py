"""Compute contact of tube with tube: vertices of one tube are pushed out of another one's capsules.

The normal force is a linear penalty, without friction. A capsule lies between two rings.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays
from tissue_sim.mechanics.touch import add_vertex_term, along_segment

wp.set_module_options({"enable_backward": False})

TUBE_STIFFNESS = wp.constant(300.0)  # N/m per vertex; assumed, as in `touch`


@wp.func
def ring_centre(
    ring: wp.array4d(dtype=int), x: wp.array2d(dtype=wp.vec3), b: int, tube: int, r: int
):
    """Return the mean of a ring's corners at positions x."""
    c = wp.vec3()
    n = ring.shape[3]
    for k in range(n):
        c = c + x[b, ring[b, tube, r, k]]
    return c / float(n)


@wp.func
def find_ring_centres(t: TissueArrays, b: int, tube: int, r: int):
    t.ring_centre[b, tube, r] = ring_centre(t.ring, t.position, b, tube, r)
    t.ring_centre_above[b, tube, r] = ring_centre(t.ring_above, t.position, b, tube, r)


@wp.func
def touched_before(t: TissueArrays, b: int, i: int, tube: int, r: int):
    """Return whether vertex i was in the tube's segment r when the step began."""
    c = ring_centre(t.ring_above, t.previous, b, tube, r)
    u = ring_centre(t.ring, t.previous, b, tube, r + 1) - c
    p = t.previous[b, i] - c
    return wp.length(p - u * along_segment(p, u)) < t.tube_radius[b, tube]


@wp.func
def push_apart(t: TissueArrays, b: int, i: int, tube: int):
    """Push vertex i of another tube out of a tube's capsules; two rings carry the reaction.

    A contact that exists at the start of the step lasts to its end, as on the liver bed.
    """
    radius = t.tube_radius[b, tube]
    x = t.position[b, i]
    nearest = float(1.0e9)
    segment = int(-1)
    share = float(0.0)
    offset = wp.vec3()
    for r in range(t.n_ring[b, tube] - 1):
        c = t.ring_centre_above[b, tube, r]
        u = t.ring_centre[b, tube, r + 1] - c
        s = along_segment(x - c, u)
        q = x - c - u * s
        d = wp.length(q)
        if d < nearest:
            nearest = d
            segment = r
            share = s
            offset = q
    touches = nearest < radius
    if segment >= 0 and not touches and nearest < 2.0 * radius:
        touches = touched_before(t, b, i, tube, segment)
    if touches:
        n = offset / (nearest + 1.0e-9)
        f = n * (TUBE_STIFFNESS * (radius - nearest))
        # The pattern has no place for the coupling [[K, -K], [-K, K]] of the two tubes. Twice its
        # diagonal exceeds this coupling: each side moves half of the way, without overshoot.
        K = wp.outer(n, n) * (2.0 * TUBE_STIFFNESS)
        add_vertex_term(t, b, i, f, K)
        count = t.ring.shape[3]
        K = K / float(count)
        for k in range(count):
            near = t.ring_above[b, tube, segment, k]
            far = t.ring[b, tube, segment + 1, k]
            add_vertex_term(t, b, near, f * ((share - 1.0) / float(count)), K * (1.0 - share))
            add_vertex_term(t, b, far, f * (-share / float(count)), K * share)


@wp.func
def push_vertex_from_earlier(t: TissueArrays, b: int, i: int, tube: int):
    if t.fixed[b, i] == 0:
        for earlier in range(tube):
            push_apart(t, b, i, earlier)


@wp.func
def push_corner_from_earlier(t: TissueArrays, b: int, tube: int, r: int, k: int):
    """Push corner k of a tube's ring r, on both sides of a cut, out of the earlier tubes."""
    below = t.ring[b, tube, r, k]
    above = t.ring_above[b, tube, r, k]
    push_vertex_from_earlier(t, b, below, tube)
    if above != below:
        push_vertex_from_earlier(t, b, above, tube)


@wp.func
def add_tube_contact(t: TissueArrays, b: int):
    """Add the contact of each tube's surface with the earlier tubes."""
    for tube in range(t.n_colliding[b]):
        for r in range(t.n_ring[b, tube]):
            find_ring_centres(t, b, tube, r)
    for later in range(1, t.n_colliding[b]):
        for r in range(t.n_ring[b, later]):
            for k in range(t.ring.shape[3]):
                push_corner_from_earlier(t, b, later, r, k)
