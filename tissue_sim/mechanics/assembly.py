"""Assemble the elements' forces and stiffness over the mesh, one thread per environment.

Most of an element's cost is its stiffness. The stiffness is kept while no vertex has moved far
since it was computed. The forces always belong to the current positions, so the kept stiffness does
not change the tissue's equilibrium. A change of topology or of an element's bulk modulus also
triggers a new stiffness.

The tissue is a Kelvin-Voigt solid. Its stress is the stress of the energy plus a viscous stress.
The viscous stress is a viscous time over the step's length, times the stiffness, times the strain
of the step.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays
from tissue_sim.mechanics.elasticity import (
    deformation_gradient,
    element,
    fibre_stiffness,
    fibre_stress,
    first_piola,
    stiffness_block,
)
from tissue_sim.mechanics.implicit import clear_blocks, copy_blocks, multiply
from tissue_sim.mechanics.lanes import LANES, add_lanes

wp.set_module_options({"enable_backward": False})

MAX_DRIFT = wp.constant(2.0e-5)  # m; turns an element of 1.5 mm by less than a degree


@wp.func
def add_block(
    block: wp.array(dtype=wp.mat33), slot: wp.array(dtype=int), i: int, j: int, K: wp.mat33
):
    """Add the block of corners i, j at its place; the matrix stores each block transposed."""
    wp.atomic_add(block, slot[4 * i + j], wp.transpose(K))


@wp.func
def add_pair(
    block: wp.array(dtype=wp.mat33), slot: wp.array(dtype=int), i: int, j: int, K: wp.mat33
):
    """Add an off-diagonal block and its transpose."""
    add_block(block, slot, i, j, K)
    add_block(block, slot, j, i, wp.transpose(K))


@wp.func
def add_stiffness(
    t: TissueArrays,
    b: int,
    e: int,
    x: wp.array(dtype=wp.vec3),
    block: wp.array(dtype=wp.mat33),
    viscosity: float,
):
    """Add an element's stiffness, elastic and viscous, for corners at positions x.

    Corner 0 balances the others: its blocks are minus their sums.
    """
    D = t.rest_inverse[b, e]
    scale = t.volume[b, e] * (1.0 + viscosity)
    F = deformation_gradient(t, b, e, x)
    h = element(F, t.mu[b, e] * scale, t.lam[b, e] * scale)
    A = t.fibre[b, e]
    M = fibre_stiffness(F, A, t.collagen[b, e] * scale)
    along = wp.vec3(wp.dot(D[0], A), wp.dot(D[1], A), wp.dot(D[2], A))
    K11 = stiffness_block(h, D[0], D[0]) + M * (along[0] * along[0])
    K22 = stiffness_block(h, D[1], D[1]) + M * (along[1] * along[1])
    K33 = stiffness_block(h, D[2], D[2]) + M * (along[2] * along[2])
    K12 = stiffness_block(h, D[0], D[1]) + M * (along[0] * along[1])
    K13 = stiffness_block(h, D[0], D[2]) + M * (along[0] * along[2])
    K23 = stiffness_block(h, D[1], D[2]) + M * (along[1] * along[2])
    K01 = -(K11 + wp.transpose(K12) + wp.transpose(K13))
    K02 = -(K12 + K22 + wp.transpose(K23))
    K03 = -(K13 + K23 + K33)
    slot = t.tet_slot[b, e]
    add_block(block, slot, 0, 0, -(K01 + K02 + K03))
    add_block(block, slot, 1, 1, K11)
    add_block(block, slot, 2, 2, K22)
    add_block(block, slot, 3, 3, K33)
    add_pair(block, slot, 0, 1, K01)
    add_pair(block, slot, 0, 2, K02)
    add_pair(block, slot, 0, 3, K03)
    add_pair(block, slot, 1, 2, K12)
    add_pair(block, slot, 1, 3, K13)
    add_pair(block, slot, 2, 3, K23)


@wp.func
def add_elastic_force(t: TissueArrays, b: int, e: int):
    """Add an element's elastic force; corner 0 balances the others."""
    force = t.force[b]
    c = t.tet[b, e]
    D = t.rest_inverse[b, e]
    F = deformation_gradient(t, b, e, t.position[b])
    P = first_piola(F, t.mu[b, e], t.lam[b, e]) + fibre_stress(F, t.fibre[b, e], t.collagen[b, e])
    P = P * t.volume[b, e]
    f1 = P * D[0]
    f2 = P * D[1]
    f3 = P * D[2]
    wp.atomic_add(force, c[0], f1 + f2 + f3)
    wp.atomic_sub(force, c[1], f1)
    wp.atomic_sub(force, c[2], f2)
    wp.atomic_sub(force, c[3], f3)


@wp.func
def has_moved_far(t: TissueArrays, b: int):
    """Return whether a vertex is far from its position when the stiffness was computed."""
    farthest = float(0.0)
    for i in range(t.n_vertex[b]):
        farthest = wp.max(farthest, wp.length_sq(t.position[b, i] - t.stiffness_at[b, i]))
    return farthest > MAX_DRIFT * MAX_DRIFT


@wp.func
def add_living(
    t: TissueArrays,
    b: int,
    x: wp.array(dtype=wp.vec3),
    force: bool,
    stiffness: bool,
    viscosity: float,
):
    """Add forces, stiffness or both of all living elements, for corners at positions x."""
    elastic = t.elastic[b]
    for first in range(0, t.n_tet[b], LANES):
        left = add_lanes(t, b, first, x, force, stiffness, elastic, viscosity)
        for lane in range(LANES):
            if (left >> lane) & 1 == 1:
                if force:
                    add_elastic_force(t, b, first + lane)
                if stiffness:
                    add_stiffness(t, b, first + lane, x, elastic, viscosity)


@wp.func
def renew_stiffness(t: TissueArrays, b: int, force: bool, viscosity: float):
    """Compute the elements' stiffness at the positions `stiffness_at`; add their forces there."""
    clear_blocks(t.elastic[b], t.row[b, t.n_vertex[b]])
    add_living(t, b, t.stiffness_at[b], force, True, viscosity)


@wp.kernel
def restore_stiffness(t: TissueArrays, viscosity: float):
    """Compute the kept stiffness of every environment again."""
    renew_stiffness(t, wp.tid(), False, viscosity)


@wp.func
def add_viscous_forces(t: TissueArrays, b: int, viscosity: float):
    """Add the viscous force on every vertex; `step` and `product` are free before the solve."""
    n = t.n_vertex[b]
    step = t.step[b]
    product = t.product[b]
    for i in range(n):
        step[i] = t.position[b, i] - t.previous[b, i]
    multiply(t.row[b], t.column[b], t.elastic[b], step, product, n)
    for i in range(n):
        t.force[b, i] = t.force[b, i] - product[i] * (viscosity / (1.0 + viscosity))


@wp.func
def add_elements(t: TissueArrays, b: int, viscosity: float):
    """Add the force and the stiffness of every living element."""
    if t.stiffness_holds[b] == 0 or has_moved_far(t, b):
        for i in range(t.n_vertex[b]):
            t.stiffness_at[b, i] = t.position[b, i]
        renew_stiffness(t, b, True, viscosity)
        t.stiffness_holds[b] = 1
    else:
        add_living(t, b, t.position[b], True, False, viscosity)
    copy_blocks(t.elastic[b], t.block[b], t.row[b, t.n_vertex[b]])
    add_viscous_forces(t, b, viscosity)
