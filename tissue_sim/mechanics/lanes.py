"""Compute forces and stiffness of sixteen elements at a time, one in each lane of a vector.

The formulas and names are those of `elasticity` and `assembly`, which compute one element
in Warp. This code is C++ because Warp has no vectors of lanes. The rotation of a collapsed element
needs the singular value decomposition, so the Warp functions compute such elements.
"""

from __future__ import annotations

import numpy as np
import warp as wp
from numpy.polynomial import Chebyshev, Polynomial

from tissue_sim.mechanics.arrays import TissueArrays
from tissue_sim.mechanics.elasticity import COLLAPSED, MAX_NEWTON, POINT, ROUNDING

wp.set_module_options({"enable_backward": False})

LANES = wp.constant(16)

# cos(acos(x) / 3) as a polynomial of u = cos(acos(x) / 2) = sqrt((1 + x) / 2): error 2e-8
_THIRD = Chebyshev.interpolate(lambda u: np.cos(np.arccos(u) / 1.5), 9, [0.0, 1.0])
_TERMS = _THIRD.convert(kind=Polynomial).coef

_TYPES = f"""
    constexpr int n_lane = {LANES}, max_newton = {MAX_NEWTON};
    constexpr float collapsed = {COLLAPSED}f, point = {POINT}f, rounding = {ROUNDING}f;
    constexpr int n_term = {len(_TERMS)};
    constexpr float series[n_term] = {{{", ".join(f"{c:.9e}f" for c in _TERMS)}}};
    typedef float lanes __attribute__((ext_vector_type(n_lane)));
    typedef int truths __attribute__((ext_vector_type(n_lane)));
    typedef wp::vec_t<3, lanes> vector;
    typedef wp::mat_t<3, 3, lanes> matrix;
    using wp::add; using wp::cross; using wp::ddot; using wp::dot; using wp::index; using wp::mul;
    using wp::outer; using wp::skew; using wp::sub; using wp::transpose;
    const auto root = [](lanes v) {{ return __builtin_elementwise_sqrt(v); }};
    const auto larger = [](lanes v, lanes w) {{ return v > w ? v : w; }};
    const auto diagonal = [](lanes v) {{
        return matrix(v, 0.0f, 0.0f, 0.0f, v, 0.0f, 0.0f, 0.0f, v);
    }};
"""

# lanes beyond the last element repeat it, and are not added
_GATHER = """
    vector edge[3], A, D[3];
    lanes volume, mu, lam, collagen;
    truths adds;
    const int last = t.n_tet.data[b] - 1;
    for (int l = 0; l < n_lane; ++l) {
        const int e = first + l < last ? first + l : last;
        const wp::vec_t<4, int>& corner = index(t.tet, b, e);
        const wp::mat_t<3, 3, float>& inverse = index(t.rest_inverse, b, e);
        const wp::vec_t<3, float>& origin = x.data[corner.c[0]];
        for (int i = 0; i < 3; ++i) {
            A.c[i][l] = index(t.fibre, b, e).c[i];
            for (int k = 0; k < 3; ++k) {
                edge[k].c[i][l] = x.data[corner.c[k + 1]].c[i] - origin.c[i];
                D[k].c[i][l] = inverse.data[k][i];
            }
        }
        volume[l] = index(t.volume, b, e);
        mu[l] = index(t.mu, b, e);
        lam[l] = index(t.lam, b, e);
        collagen[l] = index(t.collagen, b, e);
        adds[l] = -(first + l <= last && index(t.tet_alive, b, e) != 0);
    }
"""

_ROTATION = """
    const matrix F = add(add(outer(edge[0], D[0]), outer(edge[1], D[1])), outer(edge[2], D[2]));
    const vector f[3] = {F.get_col(0), F.get_col(1), F.get_col(2)};
    const matrix cofactor(cross(f[1], f[2]), cross(f[2], f[0]), cross(f[0], f[1]));
    const lanes J = dot(f[0], cofactor.get_col(0));
    const lanes one = ddot(F, F), two = ddot(cofactor, cofactor);
    lanes total = root(3.0f * one);
    for (int n = 0; n < max_newton; ++n) {
        const lanes square = total * total;
        const lanes value = ((square - 2.0f * one) * total - 8.0f * J) * total
            + one * one - 4.0f * two;
        const lanes slope = 4.0f * ((square - one) * total - 2.0f * J);
        const truths moves = value > 1.0e-6f * total * slope;
        if (!__builtin_reduce_or(moves)) break;
        total = moves ? total - value / slope : total;
    }
    const lanes gaps = total * (total * total - one) - 2.0f * J;
    const truths sound = (one > point) & (gaps > collapsed * one * root(one));
    const truths left = adds & ~sound;
    adds &= sound;
    matrix R = add(mul(F, total * total + one), mul(cofactor, 2.0f * total));
    R = mul(sub(R, mul(mul(F, mul(transpose(F), F)), lanes(2.0f))), 1.0f / gaps);
    const vector drawn = mul(F, A);
    const lanes stretch = root(dot(drawn, drawn));
    const lanes over = larger(stretch - 1.0f, 0.0f);
    const lanes tension = over > 0.0f ? collagen * over * over * over / stretch : 0.0f;
"""

_FORCE = """
    if (force) {
        matrix P = add(mul(sub(F, R), 2.0f * mu), mul(cofactor, lam * (J - 1.0f)));
        P = mul(add(P, outer(mul(drawn, tension), A)), volume);
        const vector pull[3] = {mul(P, D[0]), mul(P, D[1]), mul(P, D[2])};
        for (int l = 0; l < n_lane; ++l) {
            if (!adds[l]) continue;
            const wp::vec_t<4, int>& corner = index(t.tet, b, first + l);
            for (int i = 0; i < 3; ++i) {
                float sum = 0.0f;
                for (int k = 0; k < 3; ++k) {
                    sum += pull[k].c[i][l];
                    index(t.force, b, corner.c[k + 1]).c[i] -= pull[k].c[i][l];
                }
                index(t.force, b, corner.c[0]).c[i] += sum;
            }
        }
    }
"""

_STIFFNESS = """
    if (stiffness) {
        const lanes scale = volume * (1.0f + viscosity);
        const lanes two_mu = 2.0f * mu * scale, bulk = lam * scale;
        const matrix turned = mul(F, transpose(R));
        const matrix V = mul(add(turned, transpose(turned)), lanes(0.5f));

        // eigenvalues
        const lanes mean = total / 3.0f;
        const matrix deviator = sub(V, diagonal(mean));
        const lanes size = root(ddot(deviator, deviator) / 6.0f);
        const matrix B = mul(deviator, 1.0f / larger(size, 1.0e-9f));
        const lanes half = 0.5f * dot(B.get_col(0), cross(B.get_col(1), B.get_col(2)));
        const lanes bounded = half < -1.0f ? -1.0f : (half > 1.0f ? 1.0f : half);
        const lanes u = root(0.5f + 0.5f * bounded);
        lanes c = series[n_term - 1];
        for (int k = n_term - 2; k >= 0; --k)
            c = c * u + series[k];
        const lanes s = root(larger(3.0f - 3.0f * c * c, 0.0f));
        const lanes s0 = mean + size * 2.0f * c;
        const lanes s1 = mean + size * (s - c);
        const lanes s2 = mean - size * (s + c);

        // pressure and spin
        const lanes bound = 0.5f * two_mu / larger(s0, 1.0f);
        const lanes free = bulk * (J - 1.0f);
        const lanes pressure = free < -bound ? -bound : (free > bound ? bound : free);
        const lanes pushed = pressure < 0.0f ? pressure : 0.0f;
        const lanes least = (2.0f + rounding) / (1.0f + pushed * s0 / two_mu);
        const auto secant = [&](lanes p, lanes q) {
            const lanes across = (1.0f / q - 1.0f / least) / (q - p);
            const lanes slope = p >= least ? -1.0f / (p * q) : across;
            return ((q <= least) | (q - p < 1.0e-5f)) ? 0.0f : slope;
        };
        const lanes sum = s0 + s1 + s2, m0 = sum - s0, m1 = sum - s1, m2 = sum - s2;
        const lanes second = secant(m0, m1);
        const lanes third = m2 - m0 > 1.0e-4f ? (secant(m1, m2) - second) / (m2 - m0) : 0.0f;
        const matrix first_gap = sub(diagonal(s0), V), second_gap = sub(diagonal(s1), V);
        matrix spin = add(diagonal(1.0f / larger(m0, least)), mul(first_gap, second));
        spin = mul(add(spin, mul(mul(first_gap, second_gap), third)), two_mu);

        // blocks
        const lanes taut = over > 0.0f ? scale : 0.0f;
        const lanes curve = 3.0f * collagen * over * over;
        const vector n = mul(drawn, 1.0f / larger(stretch, 1.0e-9f));
        const matrix M = mul(add(diagonal(tension), mul(outer(n, n), curve - tension)), taut);
        vector grown[3];
        matrix turn[3], spun[3];
        lanes along[3];
        for (int k = 0; k < 3; ++k) {
            turn[k] = skew(mul(R, D[k]));
            spun[k] = mul(spin, turn[k]);
            grown[k] = mul(cofactor, D[k]);
            along[k] = dot(D[k], A);
        }
        const auto block_of = [&](int g, int h) {
            const matrix shear = add(diagonal(two_mu * dot(D[g], D[h])), mul(turn[g], spun[h]));
            const matrix swell = outer(mul(grown[g], bulk), grown[h]);
            const matrix press = skew(mul(F, mul(cross(D[h], D[g]), pressure)));
            return add(add(shear, swell), add(press, mul(M, along[g] * along[h])));
        };
        const auto balance = [](const matrix& X, const matrix& Y, const matrix& Z) {
            return mul(add(add(X, Y), Z), lanes(-1.0f));
        };
        const matrix K11 = block_of(0, 0), K12 = block_of(0, 1), K13 = block_of(0, 2);
        const matrix K22 = block_of(1, 1), K23 = block_of(1, 2), K33 = block_of(2, 2);
        const matrix K01 = balance(K11, transpose(K12), transpose(K13));
        const matrix K02 = balance(K12, K22, transpose(K23));
        const matrix K03 = balance(K13, K23, K33);
        const matrix K[4][4] = {
            {balance(K01, K02, K03), K01, K02, K03},
            {transpose(K01), K11, K12, K13},
            {transpose(K02), transpose(K12), K22, K23},
            {transpose(K03), transpose(K13), transpose(K23), K33},
        };
        for (int l = 0; l < n_lane; ++l) {
            if (!adds[l]) continue;
            const int* slot = &index(t.tet_slot, b, first + l, 0);
            for (int k = 0; k < 16; ++k) {
                const float* from = (const float*)&K[k % 4][k / 4] + l;  // stored transposed
                float* to = block.data[slot[k]].data[0];
                for (int m = 0; m < 9; ++m)
                    to[m] += from[m * n_lane];
            }
        }
    }
"""

_REPORT = """
    int mask = 0;
    for (int l = 0; l < n_lane; ++l)
        mask |= left[l] ? 1 << l : 0;
    return mask;
"""


@wp.func_native(_TYPES + _GATHER + _ROTATION + _FORCE + _STIFFNESS + _REPORT)
def add_lanes(
    t: TissueArrays,
    b: int,
    first: int,
    x: wp.array(dtype=wp.vec3),
    force: bool,
    stiffness: bool,
    block: wp.array(dtype=wp.mat33),
    viscosity: float,
) -> int:
    """Add force and stiffness of the living elements from `first` on, for corners at positions x.

    Returns:
        A bit for each living element that is collapsed; nothing was added for such an element.
    """
    ...
