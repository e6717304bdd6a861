"""Compute the preconditioner's second level: each section of the tissue moves as a rigid body.

A tube is stiff across its axis and soft along it. With the diagonal blocks alone, conjugate
gradients would propagate a motion by one section per iteration. So the mesh is divided into parts,
the rings of the sweep. The matrix is restricted to the rigid motions P of the parts and factored:

    z = D^-1 r + P (P^T A P)^-1 P^T r

The method is additive two-level Schwarz with rigid-body modes: Nicolaides, "Deflation of conjugate
gradients", 1987; Vanek, Mandel and Brezina, "Algebraic multigrid by smoothed aggregation", 1996.
Parts are numbered along the tubes. So P^T A P has a narrow skyline, and its Cholesky factor has the
same skyline.
"""

from __future__ import annotations

import numpy as np
import warp as wp
from numpy.typing import NDArray

from tissue_sim.mechanics.arrays import TissueArrays
from tissue_sim.patient.mesher import Indices

wp.set_module_options({"enable_backward": False})

MODES = wp.constant(6)  # three translations and three rotations of a part
# Share of a diagonal entry that is added to the entry. For a piece that hangs by a strand, inertia
# is far below stiffness. Rounding must not make the pivot smaller still.
DIAGONAL_SHIFT = wp.constant(1.0e-3)


def skyline(n_part: int, part: Indices, row: Indices, column: Indices) -> tuple[Indices, Indices]:
    """Return the shape of the factor of the parts' matrix P^T A P.

    Args:
        n_part: number of parts.
        part: (n_vertex,) part of each vertex, -1 for none.
        row, column: block-CSR pattern of A.

    Returns:
        For each part, the first part that couples to it, and the start of its columns in the
            storage. The six rows of part p contain the columns of the parts first[p] to p.
    """
    i = part[np.repeat(np.arange(len(row) - 1), np.diff(row))]
    j = part[column]
    both = (i >= 0) & (j >= 0)
    first = np.arange(n_part)
    np.minimum.at(first, i[both], j[both])
    length = MODES * (np.arange(n_part) - first + 1)
    start = np.concatenate([[0], np.cumsum(length)])
    return first.astype(np.int32), start.astype(np.int32)


def skyline_capacity(n_part: int) -> int:
    """Return the largest number of stored columns (of a part's six rows) of the factor."""
    return MODES * n_part * (n_part + 1) // 2


def parts_of(rings: list[Indices], n_vertex: int) -> NDArray[np.int32]:
    """Return the (n_vertex,) number of each vertex's ring, -1 for a vertex in no ring."""
    part = np.full(n_vertex, -1, np.int32)
    for k, ring in enumerate(rings):
        part[ring] = k
    return part


@wp.func_native("""
    // four lanes: the columns of A's blocks are the rows of the stored ones; lane 3 is idle
    typedef float lanes __attribute__((vector_size(16)));
    typedef float columns __attribute__((vector_size(32)));
    for (int i = 0; i < n; ++i) {
        const int p = part[i];
        if (p < 0)
            continue;
        int now = -1;
        lanes sum[6] = {};  // columns of [A_ij, -A_ij skew(arm_j)], over the vertices j of part now
        const float* w = arm.data[i].c;
        const lanes yzx = {w[1], w[2], w[0]}, zxy = {w[2], w[0], w[1]};
        const auto add_columns = [&]() {
            for (int c = 0; c < 6; ++c) {
                const lanes s = sum[c];
                const lanes moment = yzx * __builtin_shufflevector(s, s, 2, 0, 1, 3)
                    - zxy * __builtin_shufflevector(s, s, 1, 2, 0, 3);
                float* to = factor.data[start[p] + 6 * (now - first[p]) + c].c;
                columns both = {};
                __builtin_memcpy(&both, to, 6 * sizeof(float));
                both += __builtin_shufflevector(s, moment, 0, 1, 2, 4, 5, 6, 3, 7);
                __builtin_memcpy(to, &both, 6 * sizeof(float));
                sum[c] = lanes{};
            }
        };
        for (int k = row[i]; k < row[i + 1]; ++k) {
            const int j = column[k], q = part[j];
            if (q < 0 || q > p)
                continue;
            if (q != now && now >= 0)
                add_columns();
            now = q;
            const float* K = block.data[k].data[0];
            const float* v = arm.data[j].c;
            lanes a, b, c;
            __builtin_memcpy(&a, K, sizeof a);
            __builtin_memcpy(&b, K + 3, sizeof b);
            __builtin_memcpy(&c, K + 6, sizeof c);
            sum[0] += a;
            sum[1] += b;
            sum[2] += c;
            sum[3] -= b * v[2] - c * v[1];
            sum[4] -= c * v[0] - a * v[2];
            sum[5] -= a * v[1] - b * v[0];
        }
        if (now >= 0)
            add_columns();
    }
""")
def add_restricted(
    row: wp.array(dtype=int),
    column: wp.array(dtype=int),
    block: wp.array(dtype=wp.mat33),
    part: wp.array(dtype=int),
    arm: wp.array(dtype=wp.vec3),
    first: wp.array(dtype=int),
    start: wp.array(dtype=int),
    factor: wp.array(dtype=wp.spatial_vector),
    n: int,
):
    """Add P^T A P to the skyline. One number beyond the last block is read."""
    ...


@wp.func
def restrict_matrix(t: TissueArrays, b: int):
    """Compute P^T A P in the skyline."""
    factor = t.factor[b]
    start = t.factor_start[b]
    for k in range(start[t.n_part[b]]):
        factor[k] = wp.spatial_vector()
    add_restricted(
        t.row[b],
        t.column[b],
        t.block[b],
        t.part[b],
        t.arm[b],
        t.factor_first[b],
        start,
        factor,
        t.n_vertex[b],
    )


@wp.func_native("""
    // eight lanes hold a column of six
    typedef float lanes __attribute__((vector_size(32)));
    const auto load = [&](int k) {
        lanes v = {};
        __builtin_memcpy(&v, factor.data[k].c, 6 * sizeof(float));
        return v;
    };
    for (int p = 0; p < n; ++p) {
        const int mine = start[p] - 6 * first[p];  // place of column 0, if it were stored
        float rest[6];
        for (int a = 0; a < 6; ++a)
            rest[a] = factor.data[mine + 6 * p + a].c[a] * (1.0f + shift);
        for (int q = first[p]; q <= p; ++q) {
            const int theirs = start[q] - 6 * first[q];
            lanes s[6];
            for (int a = 0; a < 6; ++a)
                s[a] = load(mine + 6 * q + a);
            for (int k = 6 * (first[p] > first[q] ? first[p] : first[q]); k < 6 * q; ++k) {
                const lanes x = load(mine + k);
                for (int a = 0; a < 6; ++a)
                    s[a] -= x * factor.data[theirs + k].c[a];
            }
            for (int a = 0; a < 6; ++a) {
                const int j = 6 * q + a;
                for (int k = 6 * q; k < j; ++k)
                    s[a] -= load(mine + k) * factor.data[theirs + k].c[a];
                if (q == p)
                    pivot[j] = rest[a] > 0.0f ? 1.0f / wp::sqrt(rest[a]) : 0.0f;
                s[a] *= pivot[j];
                __builtin_memcpy(factor.data[mine + j].c, &s[a], 6 * sizeof(float));
                for (int c = 0; c < 6; ++c)
                    rest[c] -= s[a][c] * s[a][c];
            }
        }
    }
""")
def factorise_parts(
    first: wp.array(dtype=int),
    start: wp.array(dtype=int),
    factor: wp.array(dtype=wp.spatial_vector),
    pivot: wp.array(dtype=float),
    n: int,
    shift: float,
):
    """Factor by Cholesky in place; `pivot` contains the inverse diagonal, 0 for no mode.

    The six rows of a part are the lanes, so their sums do not wait for each other. The values left
    on and above the diagonal are never read.
    """
    ...


@wp.func
def factorise(t: TissueArrays, b: int):
    """Factor P^T A P in place."""
    factorise_parts(
        t.factor_first[b],
        t.factor_start[b],
        t.factor[b],
        t.factor_pivot[b],
        t.n_part[b],
        DIAGONAL_SHIFT,
    )


@wp.func
def back_substitute(t: TissueArrays, b: int):
    """Solve for `motion` in place."""
    factor = t.factor[b]
    first = t.factor_first[b]
    start = t.factor_start[b]
    pivot = t.factor_pivot[b]
    motion = t.motion[b]
    n = t.n_part[b]
    for p in range(n):
        mine = start[p] - MODES * first[p]
        s = motion[p]
        for q in range(first[p], p):
            x = motion[q]
            for a in range(6):
                s = s - factor[mine + MODES * q + a] * x[a]
        x = wp.spatial_vector()
        for a in range(6):
            x[a] = s[a] * pivot[MODES * p + a]
            s = s - factor[mine + MODES * p + a] * x[a]
        motion[p] = x
    for back in range(n):
        p = n - 1 - back
        mine = start[p] - MODES * first[p]
        x = motion[p]
        for up in range(6):
            x[5 - up] = x[5 - up] * pivot[MODES * p + 5 - up]
            for a in range(5 - up):
                x[a] = x[a] - factor[mine + MODES * p + a][5 - up] * x[5 - up]
        motion[p] = x
        for q in range(first[p], p):
            y = motion[q]
            for a in range(6):
                column = factor[mine + MODES * q + a]
                for up in range(6):
                    y[a] = y[a] - column[5 - up] * x[5 - up]
            motion[q] = y


@wp.func
def measure_parts(t: TissueArrays, b: int):
    """Compute each vertex's arm from the middle of its part; fixed vertices are in no part."""
    part = t.part[b]
    middle = t.part_middle[b]
    count = t.part_count[b]
    for p in range(t.n_part[b]):
        middle[p] = wp.vec3()
        count[p] = 0.0
    for i in range(t.n_vertex[b]):
        if t.fixed[b, i] != 0:
            part[i] = -1
        if part[i] >= 0:
            middle[part[i]] = middle[part[i]] + t.position[b, i]
            count[part[i]] = count[part[i]] + 1.0
    for i in range(t.n_vertex[b]):
        if part[i] >= 0:
            t.arm[b, i] = t.position[b, i] - middle[part[i]] / count[part[i]]


@wp.func
def prepare_coarse(t: TissueArrays, b: int):
    """Factor P^T A P, with the parts at their current places."""
    measure_parts(t, b)
    restrict_matrix(t, b)
    factorise(t, b)


@wp.func
def solve_coarse(t: TissueArrays, b: int):
    """Compute the rigid motions (P^T A P)^-1 P^T r of the parts, into `motion`."""
    part = t.part[b]
    arm = t.arm[b]
    residual = t.residual[b]
    motion = t.motion[b]
    for p in range(t.n_part[b]):
        motion[p] = wp.spatial_vector()
    for i in range(t.n_vertex[b]):
        if part[i] >= 0:
            r = residual[i]
            motion[part[i]] = motion[part[i]] + wp.spatial_vector(r, wp.cross(arm[i], r))
    back_substitute(t, b)


@wp.func
def rigid_motion(part: int, arm: wp.vec3, motion: wp.array(dtype=wp.spatial_vector)):
    """Return the motion of a vertex with its part."""
    if part < 0:
        return wp.vec3()
    return wp.spatial_top(motion[part]) + wp.cross(wp.spatial_bottom(motion[part]), arm)
