"""Second level of the preconditioner: each section of the tissue moves as a rigid body.

A tube is stiff across and soft along. With the diagonal blocks alone, conjugate gradients would
carry a motion only one section further per iteration. So the mesh is divided into parts (the rings
of the sweep), and the matrix, restricted to the rigid motions P of the parts, is factored:

    z = D^-1 r + P (P^T A P)^-1 P^T r

Additive two-level Schwarz with rigid-body modes: Nicolaides, "Deflation of conjugate gradients",
1987; Vanek, Mandel and Brezina, "Algebraic multigrid by smoothed aggregation", 1996. P^T A P has a
narrow skyline, which its Cholesky factor shares.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics import coarse
from tissue_sim.mechanics.arrays import TissueArrays

wp.set_module_options({"enable_backward": False})

MODES = wp.constant(coarse.MODES)
# Share of a diagonal entry that is added to it: for a piece that hangs by a strand, inertia is far
# below stiffness, and rounding must not make it smaller still.
DIAGONAL_SHIFT = wp.constant(1.0e-3)


@wp.func
def add_columns(
    factor: wp.array(dtype=wp.spatial_vector),
    at: int,
    top: wp.mat33,
    right: wp.mat33,
    arm: wp.vec3,
):
    """Add P_i^T [top, right] to six columns of the storage, from place `at`."""
    lever = wp.skew(arm)
    low = lever * top
    low_right = lever * right
    for c in range(3):
        factor[at + c] = factor[at + c] + column_of(top, low, c)
        factor[at + 3 + c] = factor[at + 3 + c] + column_of(right, low_right, c)


@wp.func
def column_of(top: wp.mat33, low: wp.mat33, c: int):
    """Return column c of one matrix above another."""
    return wp.spatial_vector(top[0, c], top[1, c], top[2, c], low[0, c], low[1, c], low[2, c])


@wp.func
def restrict_matrix(t: TissueArrays, b: int):
    """Compute P^T A P in the skyline."""
    part = t.part[b]
    arm = t.arm[b]
    row = t.row[b]
    column = t.column[b]
    block = t.block[b]
    factor = t.factor[b]
    first = t.factor_first[b]
    start = t.factor_start[b]
    for k in range(start[t.n_part[b]]):
        factor[k] = wp.spatial_vector()
    for i in range(t.n_vertex[b]):
        p = part[i]
        if p >= 0:
            mine = start[p] - MODES * first[p]  # place of column 0, if it were stored
            now = int(-1)
            top = wp.mat33()
            right = wp.mat33()
            for k in range(row[i], row[i + 1]):
                j = column[k]
                q = part[j]
                if q >= 0 and q <= p:
                    if q != now:
                        if now >= 0:
                            add_columns(factor, mine + MODES * now, top, right, arm[i])
                        now = q
                        top = wp.mat33()
                        right = wp.mat33()
                    K = wp.transpose(block[k])
                    top = top + K
                    right = right - K * wp.skew(arm[j])
            if now >= 0:
                add_columns(factor, mine + MODES * now, top, right, arm[i])


@wp.func
def factorise(t: TissueArrays, b: int):
    """Factor by Cholesky in place; `factor_pivot` holds the inverse diagonal, 0 for no mode.

    The six rows of a part are computed together, column by column: six independent sums instead of
    one chain. The values left on and above the diagonal are never read.
    """
    factor = t.factor[b]
    first = t.factor_first[b]
    start = t.factor_start[b]
    pivot = t.factor_pivot[b]
    for p in range(t.n_part[b]):
        mine = start[p] - MODES * first[p]  # place of column 0, if it were stored
        rest = wp.spatial_vector()
        for a in range(6):
            rest[a] = factor[mine + MODES * p + a][a] * (1.0 + DIAGONAL_SHIFT)
        for q in range(first[p], p + 1):
            theirs = start[q] - MODES * first[q]
            begin = MODES * wp.max(first[p], first[q])
            for a in range(6):
                j = MODES * q + a
                s = factor[mine + j]
                for k in range(begin, j):
                    s = s - factor[mine + k] * factor[theirs + k][a]
                if q == p:
                    pivot[j] = 0.0
                    if rest[a] > 0.0:
                        pivot[j] = 1.0 / wp.sqrt(rest[a])
                s = s * pivot[j]
                factor[mine + j] = s
                rest = rest - wp.cw_mul(s, s)


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
