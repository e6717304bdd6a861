"""Take the same step with one thread per element, spring and vertex, for a GPU.

Forces and stiffness come from the functions that the CPU's kernels use. Conjugate gradients with
the diagonal blocks and a fixed number of iterations solve the linear system. A step is therefore
one graph of launches. Sums are atomic, so on a GPU a repeated step may differ in the last bits.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays, ToolShapes
from tissue_sim.mechanics.assembly import add_elastic_force, add_stiffness, add_viscous_force
from tissue_sim.mechanics.bar_contact import place_bar, push_bar, react_to_bar
from tissue_sim.mechanics.gallbladder_contact import find_near_skin, push_ring_out_of_sac
from tissue_sim.mechanics.implicit import add_inertia, finish, predict
from tissue_sim.mechanics.springs import (
    add_anchor,
    add_link,
    add_tie,
    break_anchor,
    break_link,
    break_tie,
)
from tissue_sim.mechanics.tissue import STATE, Tissue
from tissue_sim.mechanics.touch import (
    add_bed_contact,
    add_tool_contact,
    agree_on_sides,
    find_ring_centres,
    push_corner_from_earlier,
    react,
)
from tissue_sim.mechanics.untangle import ease, mark_tangled

wp.set_module_options({"enable_backward": False})


@wp.struct
class Scalars:
    """Sums of each iteration, `[iteration, environment]`: r . M^-1 r and p . A p."""

    rz: wp.array2d(dtype=float)
    curvature: wp.array2d(dtype=float)


@wp.kernel
def begin(t: TissueArrays, s: ToolShapes, c: Scalars, h: float):
    """Clear the sums, and predict every vertex."""
    b, k = wp.tid()
    if k < t.row[b, t.n_vertex[b]]:
        t.block[b, k] = wp.mat33()
    if k < t.n_vertex[b]:
        t.tangled[b, k] = 0
        predict(t, b, k, h)
    if k < s.force.shape[1]:
        s.force[b, k] = wp.vec3()
        s.torque[b, k] = wp.vec3()
    if k < c.rz.shape[0]:
        c.rz[k, b] = 0.0
        c.curvature[k, b] = 0.0
    if k == 0:
        t.bed_force[b] = wp.vec3()


@wp.kernel
def mark_tangles(t: TissueArrays):
    b, e = wp.tid()
    if e < t.n_tet[b]:
        mark_tangled(t, b, e)


@wp.kernel
def ease_tangles(t: TissueArrays):
    b, e = wp.tid()
    if e < t.n_tet[b]:
        ease(t, b, e)


@wp.kernel
def elements(t: TissueArrays, viscosity: float):
    b, e = wp.tid()
    if e < t.n_tet[b] and t.tet_alive[b, e] != 0:
        add_elastic_force(t, b, e)
        add_stiffness(t, b, e, t.position[b], t.block[b], viscosity)


@wp.kernel
def viscous(t: TissueArrays, viscosity: float):
    b, i = wp.tid()
    if i < t.n_vertex[b]:
        add_viscous_force(t, b, i, t.block[b], viscosity)


@wp.kernel
def springs(t: TissueArrays):
    b, n = wp.tid()
    if n < t.tie_stiffness.shape[1]:
        add_tie(t, b, n)
    if n < t.link_stiffness.shape[1]:
        add_link(t, b, n)
    if n < t.anchor_stiffness.shape[1]:
        add_anchor(t, b, n)


@wp.kernel
def ring_centres(t: TissueArrays):
    b, tube, r = wp.tid()
    if r < t.n_ring[b, tube]:
        find_ring_centres(t, b, tube, r)


@wp.kernel
def tube_contact(t: TissueArrays):
    b, tube, r, k = wp.tid()
    if tube < t.n_colliding[b] and r < t.n_ring[b, tube]:
        push_corner_from_earlier(t, b, tube, r, k)


@wp.kernel
def near_skin(t: TissueArrays):
    find_near_skin(t, wp.tid())


@wp.kernel
def sac_contact(t: TissueArrays):
    b, tube, r = wp.tid()
    if tube < t.n_colliding[b] and r < t.n_ring[b, tube]:
        push_ring_out_of_sac(t, b, tube, r)


@wp.kernel
def ring_sides(t: TissueArrays):
    b, tube = wp.tid()
    agree_on_sides(t, b, tube, -1)  # every finger


@wp.kernel
def surface_contact(t: TissueArrays, s: ToolShapes):
    b, i = wp.tid()
    if i < t.n_vertex[b] and t.surface[b, i] != 0 and t.fixed[b, i] == 0:
        add_tool_contact(t, s, b, i)
        add_bed_contact(t, b, i)


@wp.kernel
def place_bars(t: TissueArrays):
    b, k = wp.tid()
    if k < t.n_bar[b]:
        place_bar(t, b, k)


@wp.kernel
def bar_contact(t: TissueArrays, s: ToolShapes):
    b, k = wp.tid()
    if k < t.n_bar[b]:
        push_bar(t, s, b, k)


@wp.kernel
def bar_reactions(t: TissueArrays, s: ToolShapes):
    b, k = wp.tid()
    if k < t.n_bar[b]:
        react_to_bar(t, s, b, k)


@wp.kernel
def start_solve(t: TissueArrays, c: Scalars, h: float, damping: float, gravity: wp.vec3):
    b, i = wp.tid()
    if i < t.n_vertex[b]:
        add_inertia(t, b, i, h, damping, gravity)
        z = t.inverse_diagonal[b, i] * t.residual[b, i]
        t.direction[b, i] = z
        wp.atomic_add(c.rz, 0, b, wp.dot(z, t.residual[b, i]))


@wp.kernel
def multiply_rows(t: TissueArrays, c: Scalars, count: int):
    b, i = wp.tid()
    if i < t.n_vertex[b]:
        y = wp.vec3()
        for k in range(t.row[b, i], t.row[b, i + 1]):
            y = y + t.direction[b, t.column[b, k]] * t.block[b, k]  # stored transposed
        t.product[b, i] = y
        wp.atomic_add(c.curvature, count, b, wp.dot(y, t.direction[b, i]))


@wp.kernel
def update_solution(t: TissueArrays, c: Scalars, count: int):
    b, i = wp.tid()
    if i < t.n_vertex[b] and c.curvature[count, b] > 0.0:
        alpha = c.rz[count, b] / c.curvature[count, b]
        r = t.residual[b, i] - t.product[b, i] * alpha
        z = t.inverse_diagonal[b, i] * r
        t.step[b, i] = t.step[b, i] + t.direction[b, i] * alpha
        t.residual[b, i] = r
        t.preconditioned[b, i] = z
        wp.atomic_add(c.rz, count + 1, b, wp.dot(z, r))


@wp.kernel
def update_direction(t: TissueArrays, c: Scalars, count: int):
    b, i = wp.tid()
    if i < t.n_vertex[b] and c.rz[count, b] > 0.0:
        beta = c.rz[count + 1, b] / c.rz[count, b]
        t.direction[b, i] = t.preconditioned[b, i] + t.direction[b, i] * beta


@wp.kernel
def finish_all(t: TissueArrays, s: ToolShapes, h: float):
    b, i = wp.tid()
    if i < t.n_vertex[b]:
        finish(t, b, i, h)
        react(t, s, b, i)


@wp.kernel
def break_all(t: TissueArrays):
    b, n = wp.tid()
    if n < t.tie_stiffness.shape[1]:
        break_tie(t, b, n)
    if n < t.link_stiffness.shape[1]:
        break_link(t, b, n)
    if n < t.anchor_stiffness.shape[1]:
        break_anchor(t, b, n)


class DataParallelTissue:
    """A copy of a `Tissue` on a device, stepped on that device.

    Events (clips, cuts) rewrite the topology on the host: call `pull`, change the tissue, call
    `push`.
    """

    def __init__(self, tissue: Tissue, *, device: str = "cuda:0", iterations: int = 200) -> None:
        self.tissue, self.device, self.iterations = tissue, device, iterations
        self.arrays, self.shapes = TissueArrays(), ToolShapes()
        self._fields = [
            (own, theirs, name)
            for own, theirs, struct in (
                (self.arrays, tissue.arrays, TissueArrays),
                (self.shapes, tissue.shapes, ToolShapes),
            )
            for name in struct.vars
        ]
        for own, theirs, name in self._fields:
            setattr(own, name, wp.clone(getattr(theirs, name), device=device))
        scalars = Scalars()
        for name in Scalars.vars:
            shape = (iterations + 1, len(tissue.organs))
            setattr(scalars, name, wp.zeros(shape, dtype=float, device=device))
        self._launches = self._prepare_launches(scalars)
        self._graph = self._capture() if self.arrays.position.device.is_cuda else None

    def push(self) -> None:
        """Copy from host to device, after the tissue has changed."""
        for own, theirs, name in self._fields:
            wp.copy(getattr(own, name), getattr(theirs, name))

    def pull(self) -> None:
        """Copy from device to host: the state and the loads on the tools."""
        for name in STATE:
            wp.copy(getattr(self.tissue.arrays, name), getattr(self.arrays, name))
        for name in ToolShapes.vars:
            wp.copy(getattr(self.tissue.shapes, name), getattr(self.shapes, name))
        wp.synchronize_device(self.device)

    def step(self) -> None:
        """Advance every environment by one step of the tissue's `config.step_s`."""
        if self._graph is None:
            self._launch()
        else:
            wp.capture_launch(self._graph)

    def _launch(self) -> None:
        for launch in self._launches:
            launch.launch()

    def _capture(self) -> Any:
        with wp.ScopedCapture(device=self.device) as capture:
            self._launch()
        return capture.graph

    def _prepare_launches(self, c: Scalars) -> list[Any]:
        """Return the launches of a step, in order."""
        t, s, config = self.arrays, self.shapes, self.tissue.config
        h, gravity = config.step_s, wp.vec3(*config.gravity_m_s2)
        vertices, blocks = t.position.shape, (t.block.shape[0], max(t.block.shape[1], 512))
        spring = max(t.tie_stiffness.shape, t.link_stiffness.shape, t.anchor_stiffness.shape)
        plan = [
            (begin, blocks, [t, s, c, h]),
            (mark_tangles, t.tet.shape, [t]),
            (ease_tangles, t.tet.shape, [t]),
            (elements, t.tet.shape, [t, config.viscosity_s / h]),
            (viscous, vertices, [t, config.viscosity_s / h]),
            (springs, spring, [t]),
            (ring_centres, t.ring_centre.shape, [t]),
            (tube_contact, t.ring.shape, [t]),
            (near_skin, t.n_skin.shape, [t]),
            (sac_contact, t.ring_centre.shape, [t]),
            (ring_sides, t.n_ring.shape, [t]),
            (surface_contact, vertices, [t, s]),
            (place_bars, t.bar_count.shape, [t]),
            (bar_contact, t.bar_count.shape, [t, s]),
            (start_solve, vertices, [t, c, h, config.damping_per_s, gravity]),
        ]
        for count in range(self.iterations):
            plan += [
                (kernel, vertices, [t, c, count])
                for kernel in (multiply_rows, update_solution, update_direction)
            ]
        plan += [
            (finish_all, vertices, [t, s, h]),
            (bar_reactions, t.bar_count.shape, [t, s]),
            (break_all, spring, [t]),
        ]
        return [
            wp.launch(kernel, dim=dim, inputs=inputs, device=self.device, record_cmd=True)
            for kernel, dim, inputs in plan
        ]
