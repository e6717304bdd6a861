"""The preconditioner's second level: each section of the tissue moves as a rigid body.

A tube is stiff across and soft along; conjugate gradients with the blocks of the diagonal alone
would carry a motion from section to section, one an iteration. So the mesh is cut into parts (the
rings of the sweep), and the matrix, restricted to the rigid motions P of the parts, is factored:

    z = D^-1 r + P (P^T A P)^-1 P^T r

Additive two-level Schwarz with rigid-body modes: Nicolaides, "Deflation of conjugate gradients",
1987; Vanek, Mandel and Brezina, "Algebraic multigrid by smoothed aggregation", 1996. P^T A P has a
narrow skyline, in which its Cholesky factor fits.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics import coarse
from tissue_sim.mechanics.arrays import TissueArrays

wp.set_module_options({"enable_backward": False})

MODES = wp.constant(coarse.MODES)
# Share of a diagonal entry that is added to it: a piece that hangs by a strand is far lighter than
# it is stiff, and rounding must not make it look lighter still.
FIRMER = wp.constant(1.0e-3)


@wp.func
def add_rows(
    factor: wp.array(dtype=float),
    at: int,
    length: int,
    top: wp.mat33,
    right: wp.mat33,
    arm: wp.vec3,
):
    """Add P_i^T [top, right] to six rows of the storage, from place `at`."""
    lever = wp.skew(arm)
    low = lever * top
    low_right = lever * right
    for a in range(3):
        for c in range(3):
            upper = at + a * length + c
            factor[upper] = factor[upper] + top[a, c]
            factor[upper + 3] = factor[upper + 3] + right[a, c]
            lower = upper + 3 * length
            factor[lower] = factor[lower] + low[a, c]
            factor[lower + 3] = factor[lower + 3] + low_right[a, c]


@wp.func
def restrict_matrix(t: TissueArrays, b: int):
    """P^T A P into the skyline."""
    part = t.part[b]
    arm = t.arm[b]
    row = t.row[b]
    column = t.column[b]
    block = t.block[b]
    factor = t.factor[b]
    first = t.factor_first[b]
    start = t.factor_start[b]
    for k in range(start[t.n_part[b]]):
        factor[k] = 0.0
    for i in range(t.n_vertex[b]):
        p = part[i]
        if p >= 0:
            length = MODES * (p - first[p] + 1)
            now = int(-1)
            top = wp.mat33()
            right = wp.mat33()
            for k in range(row[i], row[i + 1]):
                j = column[k]
                q = part[j]
                if q >= 0 and q <= p:
                    if q != now:
                        if now >= 0:
                            at = start[p] + MODES * (now - first[p])
                            add_rows(factor, at, length, top, right, arm[i])
                        now = q
                        top = wp.mat33()
                        right = wp.mat33()
                    K = wp.transpose(block[k])
                    top = top + K
                    right = right - K * wp.skew(arm[j])
            if now >= 0:
                add_rows(factor, start[p] + MODES * (now - first[p]), length, top, right, arm[i])


@wp.func
def factorise(t: TissueArrays, b: int):
    """Cholesky in place; `factor_pivot` holds the inverse of the diagonal, 0 for a missing mode."""
    factor = t.factor[b]
    first = t.factor_first[b]
    start = t.factor_start[b]
    pivot = t.factor_pivot[b]
    for p in range(t.n_part[b]):
        begin = MODES * first[p]
        length = MODES * (p - first[p] + 1)
        for a in range(MODES):
            i = MODES * p + a
            mine = start[p] + a * length - begin  # place of column 0, were it stored
            whole = factor[mine + i]
            rest = whole * (1.0 + FIRMER)
            for j in range(begin, i):
                q = j // MODES
                other_begin = MODES * first[q]
                theirs = start[q] + (j - MODES * q) * MODES * (q - first[q] + 1) - other_begin
                s = factor[mine + j]
                for k in range(wp.max(begin, other_begin), j):
                    s = s - factor[mine + k] * factor[theirs + k]
                s = s * pivot[j]
                factor[mine + j] = s
                rest = rest - s * s
            pivot[i] = 0.0
            if rest > 0.0:
                pivot[i] = 1.0 / wp.sqrt(rest)


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
        begin = MODES * first[p]
        for a in range(MODES):
            i = MODES * p + a
            mine = start[p] + a * MODES * (p - first[p] + 1) - begin
            s = motion[i]
            for k in range(begin, i):
                s = s - factor[mine + k] * motion[k]
            motion[i] = s * pivot[i]
    for back in range(n):
        p = n - 1 - back
        begin = MODES * first[p]
        for down in range(MODES):
            i = MODES * p + MODES - 1 - down
            mine = start[p] + (i - MODES * p) * MODES * (p - first[p] + 1) - begin
            x = motion[i] * pivot[i]
            motion[i] = x
            for k in range(begin, i):
                motion[k] = motion[k] - factor[mine + k] * x


@wp.func
def measure_parts(t: TissueArrays, b: int):
    """Each vertex's arm: where it is from the middle of its part. What is held fast is in none."""
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
    """Factor P^T A P, with the parts as they lie now."""
    measure_parts(t, b)
    restrict_matrix(t, b)
    factorise(t, b)


@wp.func
def solve_coarse(t: TissueArrays, b: int):
    """Rigid motions (P^T A P)^-1 P^T r of the parts, into `motion`."""
    part = t.part[b]
    arm = t.arm[b]
    residual = t.residual[b]
    motion = t.motion[b]
    for k in range(MODES * t.n_part[b]):
        motion[k] = 0.0
    for i in range(t.n_vertex[b]):
        if part[i] >= 0:
            r = residual[i]
            turn = wp.cross(arm[i], r)
            k = MODES * part[i]
            for a in range(3):
                motion[k + a] = motion[k + a] + r[a]
                motion[k + 3 + a] = motion[k + 3 + a] + turn[a]
    back_substitute(t, b)


@wp.func
def rigid_motion(part: int, arm: wp.vec3, motion: wp.array(dtype=float)):
    """How a vertex moves with its part."""
    if part < 0:
        return wp.vec3()
    k = MODES * part
    shift = wp.vec3(motion[k], motion[k + 1], motion[k + 2])
    return shift + wp.cross(wp.vec3(motion[k + 3], motion[k + 4], motion[k + 5]), arm)
