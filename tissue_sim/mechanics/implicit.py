"""Take one linearly implicit Euler step: (M / h^2 + K) dx = f + M / h^2 (x* - x).

The method is that of Baraff and Witkin, "Large steps in cloth simulation", 1998. Conjugate
gradients with a two-level preconditioner (see `coarse_motion`) solve the linear system, one thread
per environment.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays
from tissue_sim.mechanics.coarse_motion import prepare_coarse, rigid_motion, solve_coarse

wp.set_module_options({"enable_backward": False})

PREDICT = wp.constant(0.9)  # share of the inertial motion before the linearisation, assumed


@wp.struct
class StepParameters:
    """Parameters of a step.

    Attributes:
        step_s: Length of the step, s.
        viscosity: Kelvin-Voigt time over the step's length.
        damping_per_s: Mass-proportional damping, 1/s.
        gravity: Gravity in m/s^2, world frame.
        iterations: Largest number of solver iterations.
        tolerance: Bound on the preconditioned residual, relative to its start.
        settled_j: Preconditioned residual, as an energy, that always ends the iteration.
    """

    step_s: float
    viscosity: float
    damping_per_s: float
    gravity: wp.vec3
    iterations: int
    tolerance: float
    settled_j: float


@wp.func
def predict(t: TissueArrays, b: int, i: int, h: float):
    """Store the vertex's position, and move the vertex by its inertia."""
    x = t.position[b, i]
    t.previous[b, i] = x
    t.force[b, i] = t.load[b, i]
    if t.fixed[b, i] == 0:
        t.position[b, i] = x + t.velocity[b, i] * (PREDICT * h)


@wp.func_native("__builtin_memset(block.data, 0, n * sizeof(block.data[0]));")
def clear_blocks(block: wp.array(dtype=wp.mat33), n: int):
    """Set the first n blocks to zero."""
    ...


@wp.func_native("__builtin_memcpy(to.data, block.data, n * sizeof(block.data[0]));")
def copy_blocks(block: wp.array(dtype=wp.mat33), to: wp.array(dtype=wp.mat33), n: int):
    """Copy the first n blocks."""
    ...


@wp.func
def begin_step(t: TissueArrays, b: int, h: float):
    """Predict every vertex and clear the sums."""
    n = t.n_vertex[b]
    for i in range(n):
        predict(t, b, i, h)
    clear_blocks(t.block[b], t.row[b, n])


@wp.func
def add_inertia(t: TissueArrays, b: int, i: int, h: float, damping: float, gravity: wp.vec3):
    """Complete a vertex's row and right-hand side; a fixed vertex has no residual or correction."""
    t.step[b, i] = wp.vec3()
    t.residual[b, i] = wp.vec3()
    t.direction[b, i] = wp.vec3()
    t.inverse_diagonal[b, i] = wp.mat33()
    if t.fixed[b, i] == 0:
        m = t.mass[b, i]
        moved = t.position[b, i] - t.previous[b, i]
        inertia = (t.velocity[b, i] * h + gravity * (h * h) - moved) * (m / (h * h))
        t.residual[b, i] = t.force[b, i] + inertia - moved * (m * damping / h)
        slot = t.row[b, i]
        inertial = m * (1.0 + damping * h) / (h * h)
        K = t.block[b, slot] + wp.identity(n=3, dtype=float) * inertial
        t.block[b, slot] = K
        t.inverse_diagonal[b, i] = wp.inverse(K)


@wp.func
def finish(t: TissueArrays, b: int, i: int, h: float):
    """Move the vertex by its step and set its velocity."""
    if t.fixed[b, i] == 0:
        t.position[b, i] = t.position[b, i] + t.step[b, i]
        t.velocity[b, i] = (t.position[b, i] - t.previous[b, i]) / h


@wp.func_native("""
    // four lanes per block: rows of the stored (transposed) block are A's columns; lane 3 is idle
    typedef float lanes __attribute__((vector_size(16)));
    float sum = 0.0f;
    for (int i = 0; i < n; ++i) {
        lanes y = {0.0f, 0.0f, 0.0f, 0.0f};
        for (int k = row[i]; k < row[i + 1]; ++k) {
            const float* K = block.data[k].data[0];
            const float* v = x.data[column[k]].c;
            lanes a, b, c;
            __builtin_memcpy(&a, K, sizeof a);
            __builtin_memcpy(&b, K + 3, sizeof b);
            __builtin_memcpy(&c, K + 6, sizeof c);
            y += a * v[0] + b * v[1] + c * v[2];
        }
        const float* v = x.data[i].c;
        product.data[i] = wp::vec_t<3, float>(y[0], y[1], y[2]);
        sum += y[0] * v[0] + y[1] * v[1] + y[2] * v[2];
    }
    return sum;
""")
def multiply(
    row: wp.array(dtype=int),
    column: wp.array(dtype=int),
    block: wp.array(dtype=wp.mat33),
    x: wp.array(dtype=wp.vec3),
    product: wp.array(dtype=wp.vec3),
    n: int,
) -> float:
    """Compute product = A x; return x . A x. One number beyond the last block is read."""
    ...


@wp.func
def precondition(t: TissueArrays, b: int):
    """Compute preconditioned = M^-1 residual; return residual . preconditioned."""
    residual = t.residual[b]
    inverse_diagonal = t.inverse_diagonal[b]
    part = t.part[b]
    arm = t.arm[b]
    motion = t.motion[b]
    out = t.preconditioned[b]
    solve_coarse(t, b)
    rz = float(0.0)
    for i in range(t.n_vertex[b]):
        r = residual[i]
        z = inverse_diagonal[i] * r + rigid_motion(part[i], arm[i], motion)
        out[i] = z
        rz = rz + wp.dot(z, r)
    return rz


@wp.func
def solve_step(t: TissueArrays, b: int, c: StepParameters):
    """Solve for the step, move the vertices and set their velocities."""
    n = t.n_vertex[b]
    for i in range(n):
        add_inertia(t, b, i, c.step_s, c.damping_per_s, c.gravity)
    prepare_coarse(t, b)
    row = t.row[b]
    column = t.column[b]
    block = t.block[b]
    step = t.step[b]
    residual = t.residual[b]
    preconditioned = t.preconditioned[b]
    direction = t.direction[b]
    product = t.product[b]
    rz = precondition(t, b)
    enough = wp.max(c.tolerance * c.tolerance * rz, c.settled_j)
    beta = float(0.0)
    count = int(0)
    while count < c.iterations and rz > enough:
        for i in range(n):
            direction[i] = preconditioned[i] + direction[i] * beta
        curvature = multiply(row, column, block, direction, product, n)
        if curvature <= 0.0:
            break
        alpha = rz / curvature
        for i in range(n):
            step[i] = step[i] + direction[i] * alpha
            residual[i] = residual[i] - product[i] * alpha
        rz_next = precondition(t, b)
        beta = rz_next / rz
        rz = rz_next
        count = count + 1
    t.iterations[b] = count
    for i in range(n):
        finish(t, b, i, c.step_s)
