"""Assemble the elements' forces and stiffness over the mesh, one thread per environment.

Most of an element's cost is its stiffness. The stiffness is kept while no vertex has moved far
since it was computed. The forces always belong to the current positions, so the kept stiffness does
not change where tissue comes to rest. A change of topology or of an element's bulk modulus also
leads to a new stiffness.

The tissue is a Kelvin-Voigt solid: its stress is that of the energy, plus a viscous time over the
step's length, times the stiffness, times the strain of the step.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays
from tissue_sim.mechanics.elasticity import (
    deformation_gradient,
    element,
    first_piola,
    stiffness_block,
)
from tissue_sim.mechanics.fibres import fibre_stiffness, fibre_stress
from tissue_sim.mechanics.implicit import clear_blocks, copy_blocks

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
def add_viscous_force(
    t: TissueArrays, b: int, i: int, block: wp.array(dtype=wp.mat33), viscosity: float
):
    """Add the viscous force on vertex i, from the elements' stiffness alone."""
    drag = wp.vec3()
    for k in range(t.row[b, i], t.row[b, i + 1]):
        j = t.column[b, k]
        drag = drag + (t.position[b, j] - t.previous[b, j]) * block[k]  # stored transposed
    t.force[b, i] = t.force[b, i] - drag * (viscosity / (1.0 + viscosity))


@wp.func
def has_moved_far(t: TissueArrays, b: int):
    """Tell whether a vertex is far from its position when the stiffness was computed."""
    farthest = float(0.0)
    for i in range(t.n_vertex[b]):
        farthest = wp.max(farthest, wp.length_sq(t.position[b, i] - t.stiffness_at[b, i]))
    return farthest > MAX_DRIFT * MAX_DRIFT


@wp.func
def renew_stiffness(t: TissueArrays, b: int, viscosity: float):
    """Compute the elements' stiffness at the positions `stiffness_at`."""
    elastic = t.elastic[b]
    clear_blocks(elastic, t.row[b, t.n_vertex[b]])
    for e in range(t.n_tet[b]):
        if t.tet_alive[b, e] != 0:
            add_stiffness(t, b, e, t.stiffness_at[b], elastic, viscosity)


@wp.kernel
def restore_stiffness(t: TissueArrays, viscosity: float):
    """Compute the kept stiffness of every environment again."""
    renew_stiffness(t, wp.tid(), viscosity)


@wp.func
def add_elements(t: TissueArrays, b: int, viscosity: float):
    """Add the force and the stiffness of every living element."""
    if t.stiffness_holds[b] == 0 or has_moved_far(t, b):
        for i in range(t.n_vertex[b]):
            t.stiffness_at[b, i] = t.position[b, i]
        renew_stiffness(t, b, viscosity)
        t.stiffness_holds[b] = 1
    elastic = t.elastic[b]
    copy_blocks(elastic, t.block[b], t.row[b, t.n_vertex[b]])
    for e in range(t.n_tet[b]):
        if t.tet_alive[b, e] != 0:
            add_elastic_force(t, b, e)
    for i in range(t.n_vertex[b]):
        add_viscous_force(t, b, i, elastic, viscosity)
