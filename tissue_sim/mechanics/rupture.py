"""Compute the loads of the walls: the pull in each tube segment, the stretch of each patch.

The pull is the force that does work when a segment lengthens. A is the segment's direction and L
its length at rest. The unit vector a is the current direction of the segment's wall, which is the
direction of sum_e V_e F A. P is the first Piola-Kirchhoff stress. Then

    T = 1/L sum_e V_e a . P A.

The stretch of a patch is the largest principal stretch of its mean F, sum_e V_e F / sum_e V_e.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays
from tissue_sim.mechanics.elasticity import deformation_gradient, fibre_stress, first_piola

wp.set_module_options({"enable_backward": False})

# Assumed: below this stretch no wall, even with a tenth of it left, is near its strength.
SLACK_STRETCH = wp.constant(1.1)
# m^3, above any segment's: an inverted element's stress has no meaning, so its segment reads slack.
TANGLED = wp.constant(1.0)


@wp.func
def segment_gradient(t: TissueArrays, b: int, tube: int, r: int):
    """Return the rest direction of the segment above ring r over its length, 1/m."""
    n = t.ring.shape[3]
    along = wp.vec3()
    for k in range(n):
        along = along + t.rest[b, t.ring[b, tube, r + 1, k]] - t.rest[b, t.ring[b, tube, r, k]]
    return along * (float(n) / wp.dot(along, along))


@wp.func
def pull_share(t: TissueArrays, b: int, e: int, F: wp.mat33, direction: wp.vec3, gradient: wp.vec3):
    """Return a . P A / L of an element, N/m^3."""
    P = first_piola(F, t.mu[b, e], t.lam[b, e]) + fibre_stress(F, t.fibre[b, e], t.collagen[b, e])
    return wp.dot(direction, P * gradient)


@wp.func
def largest_stretch(F: wp.mat33):
    """Return the largest principal stretch of F: the root of F^T F's largest eigenvalue.

    The eigenvalues of a symmetric 3 x 3 matrix have a closed form: Smith, Commun. ACM 4, 1961, p.
    168.
    """
    C = wp.transpose(F) * F
    mean = wp.trace(C) / 3.0
    off = C - wp.identity(n=3, dtype=float) * mean
    size = wp.sqrt(wp.ddot(off, off) / 6.0)
    if size <= 1.0e-6 * mean:
        return wp.sqrt(mean)
    half = wp.clamp(0.5 * wp.determinant(off / size), -1.0, 1.0)
    return wp.sqrt(mean + 2.0 * size * wp.cos(wp.acos(half) / 3.0))


@wp.func
def real_stretch(F: wp.mat33, stiffness: float):
    """Return the real wall's stretch under the tension that gives the meshed wall the mean F."""
    return 1.0 + (largest_stretch(F) - 1.0) * stiffness


@wp.func
def clear_loads(t: TissueArrays, b: int):
    for k in range(t.n_ring.shape[1]):
        for r in range(t.n_ring[b, k] - 1):
            t.segment_pull[b, k, r] = 0.0
            t.segment_volume[b, k, r] = 0.0
            t.segment_direction[b, k, r] = wp.vec3()
            t.segment_gradient[b, k, r] = segment_gradient(t, b, k, r)
    for p in range(t.patch_stretch.shape[1]):
        t.patch_stretch[b, p] = 0.0
        t.patch_volume[b, p] = 0.0
        t.patch_shape[b, p] = wp.mat33()


@wp.func
def add_deformations(t: TissueArrays, b: int):
    """Sum V F A of each segment and V F of each patch, over living elements."""
    tube = int(-1)
    segment = int(-1)
    A = wp.vec3()
    for e in range(t.n_tet[b]):
        k = t.wall[b, e][0]
        p = t.wall[b, e][1]
        if p >= 0 and t.tet_alive[b, e] != 0:
            F = deformation_gradient(t, b, e, t.position[b])
            V = t.volume[b, e]
            if k >= 0:
                if wp.determinant(F) <= 0.0:
                    V = TANGLED
                if k != tube or p != segment:
                    tube = k
                    segment = p
                    A = wp.normalize(t.segment_gradient[b, k, p])
                t.segment_volume[b, k, p] = t.segment_volume[b, k, p] + V
                t.segment_direction[b, k, p] = t.segment_direction[b, k, p] + F * A * t.volume[b, e]
            else:
                t.patch_volume[b, p] = t.patch_volume[b, p] + V
                t.patch_shape[b, p] = t.patch_shape[b, p] + F * V


@wp.func
def add_pulls(t: TissueArrays, b: int):
    """Add up the pull in each segment that is stretched enough."""
    for e in range(t.n_tet[b]):
        k = t.wall[b, e][0]
        if k >= 0:
            r = t.wall[b, e][1]
            direction = t.segment_direction[b, k, r]
            if wp.length(direction) > SLACK_STRETCH * t.segment_volume[b, k, r]:
                F = deformation_gradient(t, b, e, t.position[b])
                gradient = t.segment_gradient[b, k, r]
                share = pull_share(t, b, e, F, wp.normalize(direction), gradient)
                t.segment_pull[b, k, r] = t.segment_pull[b, k, r] + share * t.volume[b, e]


@wp.kernel
def load_walls(t: TissueArrays):
    """Compute the pull in every segment (N; zero where it is slack), and every patch's stretch."""
    b = wp.tid()
    clear_loads(t, b)
    add_deformations(t, b)
    add_pulls(t, b)
    for p in range(t.patch_stretch.shape[1]):
        if t.patch_volume[b, p] > 0.0:
            mean = t.patch_shape[b, p] / t.patch_volume[b, p]
            t.patch_stretch[b, p] = real_stretch(mean, t.patch_stiffness[b, p])
