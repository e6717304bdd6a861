"""Fixed-corotated elasticity of one tetrahedron, and its assembly over the mesh.

    psi(F) = mu sum_i (s_i - 1)^2 + lambda / 2 (J - 1)^2,    F = U diag(s) V^T

Energy and gradient: Stomakhin et al., "Energetically consistent invertible elasticity", 2012.
The Hessian is analytic and projected to positive semi-definite through its eigensystem in the
basis of the singular vectors: Smith et al., "Analytic eigensystems for isotropic distortion
energies", 2019. Kernels run one thread an environment; they are deterministic.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.arrays import TissueArrays

wp.set_module_options({"enable_backward": False})


@wp.struct
class Element:
    """One element's stress and stiffness in the basis of its singular vectors.

    `stress` is dpsi/ds; `stretch` the 3 x 3 Hessian of psi in s; `twist_same` and `twist_cross`
    hold, for each pair of axes, the projected stiffness of rotating and shearing them.
    """

    left: wp.mat33
    right: wp.mat33
    stress: wp.vec3
    stretch: wp.mat33
    twist_same: wp.mat33
    twist_cross: wp.mat33


@wp.func
def pair_stiffness(mu: float, pressure: float, sum_s: float, other_s: float):
    """Half sum and half difference of the (projected) eigenvalues of a pair of axes."""
    shear = wp.max(2.0 * mu - pressure * other_s, 0.0)
    spin = wp.max(2.0 * mu * (1.0 - 2.0 / wp.max(sum_s, 0.5)) + pressure * other_s, 0.0)
    return wp.vec2(0.5 * (shear + spin), 0.5 * (shear - spin))


@wp.func
def element(F: wp.mat33, mu: float, lam: float):
    """Stress and projected stiffness at deformation gradient F; mu, lambda in Pa."""
    U = wp.mat33()
    s = wp.vec3()
    V = wp.mat33()
    wp.svd3(F, U, s, V)
    e = Element()
    e.left = U
    e.right = V
    pressure = lam * (s[0] * s[1] * s[2] - 1.0)
    bound = mu / wp.max(wp.abs(s[0]), 1.0)
    p = wp.clamp(pressure, -bound, bound)
    cofactor = wp.vec3(s[1] * s[2], s[2] * s[0], s[0] * s[1])
    e.stress = 2.0 * mu * (s - wp.vec3(1.0, 1.0, 1.0)) + pressure * cofactor
    e.stretch = wp.outer(cofactor, cofactor) * lam + wp.mat33(
        2.0 * mu, p * s[2], p * s[1], p * s[2], 2.0 * mu, p * s[0], p * s[1], p * s[0], 2.0 * mu
    )
    a = pair_stiffness(mu, pressure, s[0] + s[1], s[2])
    b = pair_stiffness(mu, pressure, s[0] + s[2], s[1])
    c = pair_stiffness(mu, pressure, s[1] + s[2], s[0])
    e.twist_same = wp.mat33(0.0, a[0], b[0], a[0], 0.0, c[0], b[0], c[0], 0.0)
    e.twist_cross = wp.mat33(0.0, a[1], b[1], a[1], 0.0, c[1], b[1], c[1], 0.0)
    return e


@wp.func
def stiffness_block(e: Element, g: wp.vec3, h: wp.vec3, volume: float):
    """d2E / dx_a dx_b for corners whose rotated rest gradients are g and h; N/m."""
    M = wp.cw_mul(e.stretch, wp.outer(g, h)) + wp.cw_mul(e.twist_cross, wp.outer(h, g))
    M = M + wp.diag(e.twist_same * wp.cw_mul(g, h))
    return e.left * M * wp.transpose(e.left) * volume


@wp.func
def rest_gradient(rest_inverse: wp.mat33, corner: int):
    """Gradient of a corner's shape function in the rest configuration, 1/m."""
    if corner == 0:
        return -(rest_inverse[0] + rest_inverse[1] + rest_inverse[2])
    return rest_inverse[corner - 1]


@wp.func
def deformation_gradient(t: TissueArrays, b: int, e: int):
    """F of element e, dimensionless."""
    c = t.tet[b, e]
    origin = t.position[b, c[0]]
    edges = wp.matrix_from_cols(
        t.position[b, c[1]] - origin, t.position[b, c[2]] - origin, t.position[b, c[3]] - origin
    )
    return edges * t.rest_inverse[b, e]


@wp.func
def add_block(t: TissueArrays, b: int, e: int, i: int, j: int, K: wp.mat33):
    """Add a stiffness block of corners i < j, and its transpose across the diagonal."""
    upper = t.tet_slot[b, e, 4 * i + j]
    t.block[b, upper] = t.block[b, upper] + K
    lower = t.tet_slot[b, e, 4 * j + i]
    t.block[b, lower] = t.block[b, lower] + wp.transpose(K)


@wp.kernel
def assemble_elements(t: TissueArrays):
    """Add every living element's force and stiffness."""
    b = wp.tid()
    for e in range(t.n_tet[b]):
        if t.tet_alive[b, e] != 0:
            c = t.tet[b, e]
            D = t.rest_inverse[b, e]
            volume = t.volume[b, e]
            h = element(deformation_gradient(t, b, e), t.mu[b, e], t.lam[b, e])
            V_t = wp.transpose(h.right)
            g0 = V_t * rest_gradient(D, 0)
            g1 = V_t * rest_gradient(D, 1)
            g2 = V_t * rest_gradient(D, 2)
            g3 = V_t * rest_gradient(D, 3)
            P = h.stress * volume
            t.force[b, c[0]] = t.force[b, c[0]] - h.left * wp.cw_mul(P, g0)
            t.force[b, c[1]] = t.force[b, c[1]] - h.left * wp.cw_mul(P, g1)
            t.force[b, c[2]] = t.force[b, c[2]] - h.left * wp.cw_mul(P, g2)
            t.force[b, c[3]] = t.force[b, c[3]] - h.left * wp.cw_mul(P, g3)
            k0 = t.tet_slot[b, e, 0]
            t.block[b, k0] = t.block[b, k0] + stiffness_block(h, g0, g0, volume)
            k1 = t.tet_slot[b, e, 5]
            t.block[b, k1] = t.block[b, k1] + stiffness_block(h, g1, g1, volume)
            k2 = t.tet_slot[b, e, 10]
            t.block[b, k2] = t.block[b, k2] + stiffness_block(h, g2, g2, volume)
            k3 = t.tet_slot[b, e, 15]
            t.block[b, k3] = t.block[b, k3] + stiffness_block(h, g3, g3, volume)
            add_block(t, b, e, 0, 1, stiffness_block(h, g0, g1, volume))
            add_block(t, b, e, 0, 2, stiffness_block(h, g0, g2, volume))
            add_block(t, b, e, 0, 3, stiffness_block(h, g0, g3, volume))
            add_block(t, b, e, 1, 2, stiffness_block(h, g1, g2, volume))
            add_block(t, b, e, 1, 3, stiffness_block(h, g1, g3, volume))
            add_block(t, b, e, 2, 3, stiffness_block(h, g2, g3, volume))


@wp.kernel
def elastic_energy(t: TissueArrays, energy_j: wp.array(dtype=wp.float64)):
    """Elastic energy of each environment, J."""
    b = wp.tid()
    total = wp.float64(0.0)
    for e in range(t.n_tet[b]):
        if t.tet_alive[b, e] != 0:
            U = wp.mat33()
            s = wp.vec3()
            V = wp.mat33()
            wp.svd3(deformation_gradient(t, b, e), U, s, V)
            stretch = s - wp.vec3(1.0, 1.0, 1.0)
            dJ = s[0] * s[1] * s[2] - 1.0
            psi = t.mu[b, e] * wp.dot(stretch, stretch) + 0.5 * t.lam[b, e] * dJ * dJ
            total = total + wp.float64(psi * t.volume[b, e])
    energy_j[b] = total
