"""One linearly implicit Euler step: (M / h^2 + K) dx = f + M / h^2 (x* - x).

Baraff and Witkin, "Large steps in cloth simulation", 1998; the linear system by conjugate
gradients with a block-Jacobi preconditioner, one thread an environment.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.arrays import TissueArrays

wp.set_module_options({"enable_backward": False})

PREDICT = wp.constant(0.9)  # share of the inertial motion taken before linearising


@wp.kernel
def begin_step(t: TissueArrays, h: float):
    """Remember where the step starts, move with the inertia, and clear the sums."""
    b = wp.tid()
    n = t.n_vertex[b]
    for i in range(n):
        x = t.position[b, i]
        t.previous[b, i] = x
        t.force[b, i] = t.load[b, i]
        if t.fixed[b, i] == 0:
            t.position[b, i] = x + t.velocity[b, i] * (PREDICT * h)
    for k in range(t.row[b, n]):
        t.block[b, k] = wp.mat33()


@wp.kernel
def solve_step(
    t: TissueArrays, h: float, damping: float, gravity: wp.vec3, most: int, tolerance: float
):
    """Solve for the step, move the vertices and set their velocities.

    Args:
        h: step, s.
        damping: mass-proportional, 1/s.
        gravity: m/s^2, world frame.
        most: iterations at most.
        tolerance: of the preconditioned residual, relative to its start.
    """
    b = wp.tid()
    n = t.n_vertex[b]
    per_h2 = 1.0 / (h * h)
    rz = float(0.0)
    for i in range(n):
        t.step[b, i] = wp.vec3()
        t.direction[b, i] = wp.vec3()
        if t.fixed[b, i] == 0:
            m = t.mass[b, i]
            x = t.position[b, i]
            moved = x - t.previous[b, i]
            inertia = (t.velocity[b, i] * h + gravity * (h * h) - moved) * (m * per_h2)
            r = t.force[b, i] + inertia - moved * (m * damping / h)
            slot = t.row[b, i]
            inertial = m * per_h2 * (1.0 + damping * h)
            K = t.block[b, slot] + wp.identity(n=3, dtype=float) * inertial
            t.block[b, slot] = K
            K_inverse = wp.inverse(K)
            z = K_inverse * r
            t.inverse_diagonal[b, i] = K_inverse
            t.residual[b, i] = r
            t.direction[b, i] = z
            rz = rz + wp.dot(z, r)
    start = rz
    count = int(0)
    while count < most and rz > tolerance * tolerance * start and rz > 0.0:
        curvature = float(0.0)
        for i in range(n):
            if t.fixed[b, i] == 0:
                y = wp.vec3()
                for k in range(t.row[b, i], t.row[b, i + 1]):
                    y = y + t.block[b, k] * t.direction[b, t.column[b, k]]
                t.product[b, i] = y
                curvature = curvature + wp.dot(y, t.direction[b, i])
        alpha = rz / curvature
        rz_next = float(0.0)
        for i in range(n):
            if t.fixed[b, i] == 0:
                t.step[b, i] = t.step[b, i] + t.direction[b, i] * alpha
                r = t.residual[b, i] - t.product[b, i] * alpha
                z = t.inverse_diagonal[b, i] * r
                t.residual[b, i] = r
                t.preconditioned[b, i] = z
                rz_next = rz_next + wp.dot(z, r)
        beta = rz_next / rz
        rz = rz_next
        for i in range(n):
            if t.fixed[b, i] == 0:
                t.direction[b, i] = t.preconditioned[b, i] + t.direction[b, i] * beta
        count = count + 1
    t.iterations[b] = count
    for i in range(n):
        if t.fixed[b, i] == 0:
            t.position[b, i] = t.position[b, i] + t.step[b, i]
            t.velocity[b, i] = (t.position[b, i] - t.previous[b, i]) / h
