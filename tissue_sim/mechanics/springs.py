"""Compute the springs in the tissue: ties, links and anchors; each breaks above its strength.

Spring energies are E = k/2 |r|^2 with r the weighted offset (ties, anchors) or E = k/2 (l - L)^2
with l the distance (links). A broken spring has stiffness zero. `strands` has the links that an
instrument has caught.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays

wp.set_module_options({"enable_backward": False})


@wp.func
def tie_offset(t: TissueArrays, b: int, n: int):
    """Return the offset of the tied vertex from its place in the sac, m."""
    r = wp.vec3()
    for k in range(5):
        r = r + t.position[b, t.tie_corner[b, n, k]] * t.tie_weight[b, n, k]
    return r


@wp.func
def add_tie(t: TissueArrays, b: int, n: int):
    k = t.tie_stiffness[b, n]
    if k > 0.0:
        I = wp.identity(n=3, dtype=float)
        pull = tie_offset(t, b, n) * (-k)
        for i in range(5):
            wp.atomic_add(t.force, b, t.tie_corner[b, n, i], pull * t.tie_weight[b, n, i])
            for j in range(5):
                scale = k * t.tie_weight[b, n, i] * t.tie_weight[b, n, j]
                wp.atomic_add(t.block, b, t.tie_slot[b, n, 5 * i + j], I * scale)


@wp.func
def add_link(t: TissueArrays, b: int, n: int):
    k = t.link_stiffness[b, n]
    if k > 0.0 and t.strand_shape[b, n] < 0:
        i = t.link[b, n][0]
        j = t.link[b, n][1]
        d = t.position[b, j] - t.position[b, i]
        length = wp.length(d) + 1.0e-9
        along = d / length
        pull = along * (k * (length - t.link_rest[b, n]))
        wp.atomic_add(t.force, b, i, pull)
        wp.atomic_sub(t.force, b, j, pull)
        across = wp.max(1.0 - t.link_rest[b, n] / length, 0.0)
        A = wp.outer(along, along)
        K = (A + (wp.identity(n=3, dtype=float) - A) * across) * k
        wp.atomic_add(t.block, b, t.link_slot[b, n, 0], K)
        wp.atomic_sub(t.block, b, t.link_slot[b, n, 1], K)
        wp.atomic_sub(t.block, b, t.link_slot[b, n, 2], K)
        wp.atomic_add(t.block, b, t.link_slot[b, n, 3], K)


@wp.func
def add_anchor(t: TissueArrays, b: int, n: int):
    k = t.anchor_stiffness[b, n]
    if k > 0.0:
        v = t.anchor[b, n]
        wp.atomic_add(t.force, b, v, (t.anchor_point[b, n] - t.position[b, v]) * k)
        wp.atomic_add(t.block, b, t.row[b, v], wp.identity(n=3, dtype=float) * k)


@wp.func
def add_springs(t: TissueArrays, b: int):
    """Add the force and stiffness of every spring."""
    for n in range(t.tie_stiffness.shape[1]):
        add_tie(t, b, n)
    for n in range(t.link_stiffness.shape[1]):
        add_link(t, b, n)
    for n in range(t.anchor_stiffness.shape[1]):
        add_anchor(t, b, n)


@wp.func
def break_tie(t: TissueArrays, b: int, n: int):
    if t.tie_stiffness[b, n] * wp.length(tie_offset(t, b, n)) > t.tie_strength[b, n]:
        t.tie_stiffness[b, n] = 0.0


@wp.func
def break_link(t: TissueArrays, b: int, n: int):
    length = wp.length(t.position[b, t.link[b, n][1]] - t.position[b, t.link[b, n][0]])
    tension = t.link_stiffness[b, n] * (length - t.link_rest[b, n])
    if tension > t.link_strength[b, n] and t.strand_shape[b, n] < 0:
        t.link_stiffness[b, n] = 0.0


@wp.func
def break_anchor(t: TissueArrays, b: int, n: int):
    d = t.anchor_point[b, n] - t.position[b, t.anchor[b, n]]
    if t.anchor_stiffness[b, n] * wp.length(d) > t.anchor_strength[b, n]:
        t.anchor_stiffness[b, n] = 0.0


@wp.func
def break_springs(t: TissueArrays, b: int):
    """Break springs that carry more than their strength; they do not recover."""
    for n in range(t.tie_stiffness.shape[1]):
        break_tie(t, b, n)
    for n in range(t.link_stiffness.shape[1]):
        break_link(t, b, n)
    for n in range(t.anchor_stiffness.shape[1]):
        break_anchor(t, b, n)


@wp.kernel
def spring_energy(t: TissueArrays, energy_j: wp.array(dtype=wp.float64)):
    """Compute the energy of all springs of each environment, J."""
    b = wp.tid()
    total = wp.float64(0.0)
    for n in range(t.tie_stiffness.shape[1]):
        total = total + wp.float64(0.5 * t.tie_stiffness[b, n] * wp.length_sq(tie_offset(t, b, n)))
    for n in range(t.link_stiffness.shape[1]):
        length = wp.length(t.position[b, t.link[b, n][1]] - t.position[b, t.link[b, n][0]])
        stretch = length - t.link_rest[b, n]
        total = total + wp.float64(0.5 * t.link_stiffness[b, n] * stretch * stretch)
    for n in range(t.anchor_stiffness.shape[1]):
        d = t.anchor_point[b, n] - t.position[b, t.anchor[b, n]]
        total = total + wp.float64(0.5 * t.anchor_stiffness[b, n] * wp.length_sq(d))
    energy_j[b] = total
