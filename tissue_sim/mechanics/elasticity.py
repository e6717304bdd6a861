"""Compute the fixed-corotated elasticity of one tetrahedron, and its collagen fibres.

    psi(F) = mu |F - R|^2 + lambda / 2 (J - 1)^2,    F = R S,  J = det F

Energy and gradient: Stomakhin et al., "Energetically consistent invertible elasticity", 2012. R and
the stiffness come from the invariants of F, without a singular value decomposition: Lin et al.,
"Isotropic ARAP energy using Cauchy-Green invariants", 2022. The eigenvalues are those of Smith et
al., "Analytic eigensystems for isotropic distortion energies", 2019. Bounds on these eigenvalues
keep the stiffness positive semi-definite.

The collagen fibres in a wall carry load only when stretched, and then stiffen:

    psi(F) = c / 4 (s - 1)^4  for s > 1, else 0,      s = |F A|

with the fibres' direction A at rest. Fibres that act in tension alone are from Holzapfel, Gasser
and Ogden, "A new constitutive framework for arterial wall mechanics", 2000. Here the law is a
power, because their exponential overflows in a step that overshoots. A crushed lumen does not
stiffen: its wall is pressed and bent but not stretched along the tube.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays

wp.set_module_options({"enable_backward": False})

COLLAPSED = wp.constant(0.05)  # of the invariants' scale: below this share R comes from the SVD
POINT = wp.constant(
    1.0e-12
)  # |F|^2 below which powers of the invariants leave the range of float32
MAX_NEWTON = wp.constant(20)
ROUNDING = wp.constant(1.0e-5)  # of the stretches: a margin that keeps every axis stable


@wp.func
def fibre_stress(F: wp.mat33, along: wp.vec3, c: float):
    """Return the fibres' first Piola-Kirchhoff stress, in the unit of c."""
    drawn = F * along
    stretch = wp.length(drawn)
    over = stretch - 1.0
    if over <= 0.0:
        return wp.mat33()
    tension = c * over * over * over / stretch
    return wp.outer(drawn * tension, along * 1.0)


@wp.func
def fibre_stiffness(F: wp.mat33, along: wp.vec3, c: float):
    """Return M such that the block of corners with rest gradients g and h is (g.A) (h.A) M."""
    drawn = F * along
    stretch = wp.length(drawn)
    over = stretch - 1.0
    if over <= 0.0:
        return wp.mat33()
    n = drawn / stretch
    tension = c * over * over * over / stretch
    slope = 3.0 * c * over * over
    return wp.identity(n=3, dtype=float) * tension + wp.outer(n, n) * (slope - tension)


@wp.func
def fibre_energy(F: wp.mat33, along: wp.vec3, c: float):
    """Return psi, in the unit of c."""
    over = wp.max(wp.length(F * along) - 1.0, 0.0)
    return 0.25 * c * over * over * over * over


@wp.struct
class Element:
    """State and stiffness of one element; Pa.

    Attributes:
        F, cofactor: deformation gradient, and its cofactor matrix dJ/dF.
        rotation: R, the nearest rotation.
        spin: (tr S I - V)^-1 with V = F R^T, bounded where an axis would lose stability.
        pressure: lambda (J - 1), bounded.
    """

    F: wp.mat33
    cofactor: wp.mat33
    rotation: wp.mat33
    spin: wp.mat33
    mu: float
    lam: float
    pressure: float


@wp.func
def cofactor_of(F: wp.mat33):
    """Return dJ/dF: each column is the cross product of the other two columns of F."""
    a = wp.vec3(F[0, 0], F[1, 0], F[2, 0])
    b = wp.vec3(F[0, 1], F[1, 1], F[2, 1])
    c = wp.vec3(F[0, 2], F[1, 2], F[2, 2])
    return wp.matrix_from_cols(wp.cross(b, c), wp.cross(c, a), wp.cross(a, b))


@wp.func
def stretch_sum(first: float, second: float, J: float):
    """Return tr S, the largest root of x^4 - 2 first x^2 - 8 J x + first^2 - 4 second.

    `first` is |F|^2 and `second` |cof F|^2. Newton's method starts above the root and is monotone.
    """
    x = wp.sqrt(3.0 * first)
    for _ in range(MAX_NEWTON):
        value = ((x * x - 2.0 * first) * x - 8.0 * J) * x + first * first - 4.0 * second
        slope = 4.0 * ((x * x - first) * x - 2.0 * J)
        if value <= 1.0e-6 * x * slope:
            break
        x = x - value / slope
    return x


@wp.func
def determinant(F: wp.mat33, cofactor: wp.mat33):
    """Return J from a column of the cofactor matrix."""
    return F[0, 0] * cofactor[0, 0] + F[1, 0] * cofactor[1, 0] + F[2, 0] * cofactor[2, 0]


@wp.func
def polar(F: wp.mat33, cofactor: wp.mat33, J: float):
    """Return R and tr S of F: R = d(tr S)/dF, or from the SVD if F is collapsed."""
    first = wp.ddot(F, F)
    total = stretch_sum(first, wp.ddot(cofactor, cofactor), J)
    gaps = total * (total * total - first) - 2.0 * J  # (s0 + s1) (s1 + s2) (s2 + s0)
    if first > POINT and gaps > COLLAPSED * first * wp.sqrt(first):
        C = wp.transpose(F) * F
        R = F * (total * total + first) + cofactor * (2.0 * total) - F * C * 2.0
        return R / gaps, total
    U = wp.mat33()
    s = wp.vec3()
    V = wp.mat33()
    size = wp.max(wp.sqrt(first), 1.0e-6)
    wp.svd3(F / size, U, s, V)
    return U * wp.transpose(V), (s[0] + s[1] + s[2]) * size


@wp.func
def eigenvalues(V: wp.mat33, mean: float):
    """Return the eigenvalues of a symmetric matrix with that mean eigenvalue, largest first.

    The method is the trigonometric solution of the cubic, on the deviator scaled to unit size:
    Smith, "Eigenvalues of a symmetric 3 x 3 matrix", 1961.
    """
    A = V - wp.diag(wp.vec3(mean, mean, mean))
    size = wp.sqrt(wp.ddot(A, A) / 6.0)
    B = A / wp.max(size, 1.0e-9)
    c = wp.cos(wp.acos(wp.clamp(0.5 * wp.determinant(B), -1.0, 1.0)) / 3.0)
    s = wp.sqrt(wp.max(3.0 - 3.0 * c * c, 0.0))
    return wp.vec3(mean + size * 2.0 * c, mean + size * (s - c), mean - size * (s + c))


@wp.func
def secant(a: float, b: float, least: float):
    """Return the divided difference of m -> 1 / max(m, least) for a <= b."""
    if b <= least or b - a < 1.0e-5:
        return 0.0
    if a >= least:
        return -1.0 / (a * b)
    return (1.0 / b - 1.0 / least) / (b - a)


@wp.func
def spin_of(V: wp.mat33, s: wp.vec3, least: float):
    """Return the inverse of tr V I - V, whose eigenvalues are first raised to `least`.

    The vector s contains the eigenvalues of V. The method is Newton interpolation of a matrix
    function at its eigenvalues m in ascending order.
    """
    total = s[0] + s[1] + s[2]
    a = total - s[0]
    b = total - s[1]
    c = total - s[2]
    first = 1.0 / wp.max(a, least)
    second = secant(a, b, least)
    A = wp.diag(wp.vec3(s[0], s[0], s[0])) - V  # M - a
    N = wp.diag(wp.vec3(first, first, first)) + A * second
    if c - a > 1.0e-4:
        B = wp.diag(wp.vec3(s[1], s[1], s[1])) - V  # M - b
        N = N + A * B * ((secant(b, c, least) - second) / (c - a))
    return N


@wp.func
def first_piola(F: wp.mat33, mu: float, lam: float):
    """Return the first Piola-Kirchhoff stress P = dpsi/dF in Pa, the unit of mu and lambda."""
    cofactor = cofactor_of(F)
    J = determinant(F, cofactor)
    rotation, _ = polar(F, cofactor, J)
    return (F - rotation) * (2.0 * mu) + cofactor * (lam * (J - 1.0))


@wp.func
def element(F: wp.mat33, mu: float, lam: float):
    """Return the stiffness at deformation gradient F; mu, lambda in Pa.

    The spins' stiffness 2 mu - 4 mu / (s_i + s_j) + p s_k becomes negative under compression.
    Therefore s_i + s_j is raised until this stiffness is no longer negative. The pressure p is
    bounded by mu over the largest stretch, which keeps the stiffness of shears and stretches
    positive.
    """
    e = Element()
    e.F = F
    e.cofactor = cofactor_of(F)
    J = determinant(F, e.cofactor)
    rotation, total = polar(F, e.cofactor, J)
    e.rotation = rotation
    V = F * wp.transpose(rotation)
    V = (V + wp.transpose(V)) * 0.5
    s = eigenvalues(V, total / 3.0)
    pressure = lam * (J - 1.0)
    bound = mu / wp.max(s[0], 1.0)
    e.pressure = wp.clamp(pressure, -bound, bound)
    least = (2.0 + ROUNDING) / (1.0 + wp.min(e.pressure, 0.0) * s[0] / (2.0 * mu))
    e.spin = spin_of(V, s, least)
    e.mu = mu
    e.lam = lam
    return e


@wp.func
def stiffness_block(e: Element, g: wp.vec3, h: wp.vec3):
    """Return d2 psi / dx_a dx_b for corners whose rest gradients (1/m) are g and h."""
    shear = 2.0 * e.mu * wp.dot(g, h)
    turn = wp.skew(e.rotation * g) * (e.spin * wp.skew(e.rotation * h)) * (2.0 * e.mu)
    volume = wp.outer(e.cofactor * g * e.lam, e.cofactor * h)
    pressure = wp.skew(e.F * wp.cross(h, g) * e.pressure)
    return wp.diag(wp.vec3(shear, shear, shear)) + turn + volume + pressure


@wp.func
def deformation_gradient(t: TissueArrays, b: int, e: int, x: wp.array(dtype=wp.vec3)):
    """Return F of element e with its corners at positions x, dimensionless."""
    c = t.tet[b, e]
    origin = x[c[0]]
    edges = wp.matrix_from_cols(x[c[1]] - origin, x[c[2]] - origin, x[c[3]] - origin)
    return edges * t.rest_inverse[b, e]


@wp.kernel
def elastic_energy(t: TissueArrays, energy_j: wp.array(dtype=wp.float64)):
    """Compute the elastic energy of each environment, J."""
    b = wp.tid()
    total = wp.float64(0.0)
    for e in range(t.n_tet[b]):
        if t.tet_alive[b, e] != 0:
            U = wp.mat33()
            s = wp.vec3()
            V = wp.mat33()
            F = deformation_gradient(t, b, e, t.position[b])
            wp.svd3(F, U, s, V)
            stretch = s - wp.vec3(1.0, 1.0, 1.0)
            dJ = s[0] * s[1] * s[2] - 1.0
            psi = t.mu[b, e] * wp.dot(stretch, stretch) + 0.5 * t.lam[b, e] * dJ * dJ
            psi = psi + fibre_energy(F, t.fibre[b, e], t.collagen[b, e])
            total = total + wp.float64(psi * t.volume[b, e])
    energy_j[b] = total
