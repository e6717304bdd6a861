"""The tissue of a batch of environments: allocate, step, rewire, save and restore."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp
from numpy.typing import NDArray

from tissue_sim import contact, elasticity, implicit, springs
from tissue_sim.arrays import TissueArrays, ToolShapes
from tissue_sim.frames import Array
from tissue_sim.material import (
    ANCHOR_STIFFNESS,
    ANCHOR_STRENGTH,
    DENSITY_KG_M3,
    REMNANT_STIFFNESS,
    REMNANT_STRENGTH,
    TIE_STIFFNESS,
    TIE_STRENGTH,
    lame_of,
)
from tissue_sim.organ import REGIONS, TUBES, Organ
from tissue_sim.sweep import Indices, signed_volumes
from tissue_sim.topology import block_pattern, boundary_faces

SPARE_VERTICES = 96  # room for cuts: a transection takes 13
LINK_CAPACITY = 512  # room for remnants and clips: a clip takes about 27
N_SHAPES = 8  # shaft, wrist and two jaws of two arms
UNBREAKABLE = 1.0e9  # N

# What a step or an event changes; the rest follows from the organ or from these.
STATE = (
    "n_vertex", "position", "rest", "rest_inverse", "volume", "velocity", "mass", "surface", "covered", "load", "tet", "tet_alive",
    "tie_stiffness", "link", "link_rest", "link_stiffness", "link_strength", "anchor_stiffness",
    "contact_shape", "contact_side", "contact_force", "stick_point", "ring", "ring_joined",
    "bed_force",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class TissueConfig:
    """How the tissue is stepped."""

    step_s: float = 1.0 / 60.0  # two steps a control step: one leaves tangles after a crush
    damping_per_s: float = 5.0  # mass-proportional, assumed
    gravity_m_s2: tuple[float, float, float] = (0.0, 0.0, -9.81)
    iterations: int = 60
    tolerance: float = 1.0e-2


class Tissue:
    """Finite-element tissue of one or more environments, stepped together on one device."""

    def __init__(
        self,
        organs: Sequence[Organ],
        *,
        stiffness_scale: Sequence[float] | None = None,
        config: TissueConfig | None = None,
        device: str = "cpu",
    ) -> None:
        self.config = config or TissueConfig()
        self.organs = tuple(organs)
        self.device = device
        scales = stiffness_scale or [1.0] * len(self.organs)
        self._allocate()
        for b, (organ, scale) in enumerate(zip(self.organs, scales, strict=True)):
            self._fill(b, organ, scale)
            self.rewire(b)
        self._record()

    def host(self, name: str) -> NDArray:
        """An array as numpy; on the CPU it shares memory with the device's."""
        return getattr(self.arrays, name).numpy()

    def positions(self, b: int = 0) -> Array:
        """(n_vertex, 3) positions of one environment, m."""
        return self.host("position")[b, : self.n_vertex(b)]

    def n_vertex(self, b: int = 0) -> int:
        """Vertices in use."""
        return int(self.host("n_vertex")[b])

    def tets(self, b: int = 0) -> NDArray[np.int32]:
        """(n_tet, 4) corners, severed parts included, dead elements too."""
        return self.host("tet")[b, : len(self.organs[b].tets)]

    def step(self) -> None:
        """Advance every environment by one step of `config.step_s`."""
        for launch in self.stages.values():
            launch.launch()

    def place_tools(self, env: int, **values: Array) -> None:
        """Put the instruments' contact shapes where they are: arrays (8, ...) by field name of
        `ToolShapes`, world frame."""
        for name, value in values.items():
            getattr(self.shapes, name).numpy()[env] = value

    def tool_wrenches(self, b: int = 0) -> tuple[Array, Array]:
        """Force (8, 3) N and torque (8, 3) N m about each link's origin, on the instruments."""
        return self.shapes.force.numpy()[b], self.shapes.torque.numpy()[b]

    def add_links(
        self, b: int, pairs: Array, *, rest_m: Array, stiffness: Array | float, strength_n: float
    ) -> NDArray[np.int64]:
        """New springs between pairs (n, 2) of vertices; call `rewire` after. Returns their rows.

        Raises:
            ValueError: there is no room left.
        """
        stiff = self.host("link_stiffness")[b]
        free = np.flatnonzero(stiff == 0.0)[: len(pairs)]
        if len(free) < len(pairs):
            raise ValueError(f"tissue: no room for {len(pairs)} links (capacity {LINK_CAPACITY})")
        self.host("link")[b, free] = pairs
        self.host("link_rest")[b, free] = rest_m
        self.host("link_strength")[b, free] = strength_n
        stiff[free] = stiffness
        return free

    def duplicate(self, b: int, parents: Sequence[int]) -> None:
        """Append a copy of each parent vertex, where it is and as fast as it is."""
        n = self.n_vertex(b)
        if n + len(parents) > self.host("position").shape[1]:
            raise ValueError(f"tissue: no spare vertices left (capacity {SPARE_VERTICES})")
        new = slice(n, n + len(parents))
        for name in ("position", "rest", "velocity", "fixed", "contact_shape", "surface"):
            values = self.host(name)
            values[b, new] = values[b, list(parents)]
        self.host("contact_shape")[b, new] = -1
        self.host("n_vertex")[b] = n + len(parents)

    def slide(self, b: int, vertices: Indices, towards: Indices, share: float) -> None:
        """Move vertices along edges to others, by a share of them, at rest and now alike."""
        for name in ("position", "velocity", "rest"):
            values = self.host(name)[b]
            values[vertices] += share * (values[towards] - values[vertices])
        around = np.flatnonzero(np.isin(self.tets(b), vertices).any(axis=1))
        self._shape_elements(b, around)

    def _shape_elements(self, b: int, elements: Indices) -> None:
        """Rest shape matrices and volumes from the rest positions."""
        rest = self.host("rest")[b].astype(np.float64)
        corners = rest[self.tets(b)[elements]]
        edges = (corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
        self.host("rest_inverse")[b, elements] = np.linalg.inv(edges)
        self.host("volume")[b, elements] = signed_volumes(rest, self.tets(b)[elements])

    def rewire(self, b: int) -> None:
        """Rebuild matrix pattern, masses and touchable surface after a change of topology."""
        n, tets = self.n_vertex(b), self.tets(b)
        row, column, (tet, tie, link) = block_pattern(
            n, [tets, self.host("tie_corner")[b], self.host("link")[b]]
        )
        if len(column) > self.host("column").shape[1]:
            raise ValueError("tissue: the stiffness matrix outgrew its capacity")
        self.host("row")[b, : n + 1] = row
        self.host("column")[b, : len(column)] = column
        self.host("tet_slot")[b, : len(tet)] = tet
        self.host("tie_slot")[b] = tie
        self.host("link_slot")[b] = link
        self._weigh(b)
        alive = self.host("tet_alive")[b, : len(tets)] != 0
        faces, _ = boundary_faces(tets[alive])
        surface = self.host("surface")[b]
        surface[:] = 0
        surface[np.unique(faces)] = 1
        surface[self.host("covered")[b] != 0] = 0
        self.host("contact_shape")[b, surface == 0] = -1

    def state(self) -> dict[str, NDArray]:
        """A copy of everything that changes, topology included."""
        return {name: self.host(name).copy() for name in STATE}

    def restore(self, state: dict[str, NDArray]) -> None:
        """Put back what `state` returned.

        Raises:
            ValueError: the state is of another tissue; nothing is changed.
        """
        for name in STATE:
            if name not in state or state[name].shape != self.host(name).shape:
                raise ValueError(f"state: {name} is missing or of another shape")
        for name in STATE:
            self.host(name)[:] = state[name]
        for b in range(len(self.organs)):
            self.rewire(b)

    def elastic_energy_j(self) -> Array:
        """(n_env,) elastic energy of elements and springs."""
        total = np.zeros(len(self.organs))
        for kernel in (elasticity.elastic_energy, springs.spring_energy):
            out = wp.zeros(len(self.organs), dtype=wp.float64, device=self.device)
            wp.launch(kernel, dim=len(self.organs), inputs=[self.arrays, out], device=self.device)
            total += out.numpy()
        return total

    def volumes(self, b: int = 0) -> Array:
        """(n_tet,) current volumes of the elements, m^3; negative when inverted."""
        return signed_volumes(self.positions(b).astype(np.float64), self.tets(b))

    def _allocate(self) -> None:
        n_env, organs = len(self.organs), self.organs
        n_vertex = max(len(o.vertices) for o in organs) + SPARE_VERTICES
        n_tet = max(len(o.tets) for o in organs)
        n_tie = max(len(o.tie_vertex) for o in organs)
        n_anchor = max(len(o.bed_vertices) for o in organs)
        n_ring = max(len(r) for o in organs for r in o.rings.values())
        n_around = (next(iter(organs[0].rings.values())).shape[1] - 1) // 2
        sizes = {
            "n_vertex": (), "n_tet": (), "bed_point": (), "bed_normal": (), "bed_along": (),
            "bed_edge": (), "bed_force": (), "iterations": (),
            "tet": (n_tet,), "tet_alive": (n_tet,), "rest_inverse": (n_tet,), "volume": (n_tet,),
            "mu": (n_tet,), "lam": (n_tet,), "tet_slot": (n_tet, 16),
            "tie_corner": (n_tie, 5), "tie_weight": (n_tie, 5), "tie_slot": (n_tie, 25),
            "tie_stiffness": (n_tie,), "tie_strength": (n_tie,),
            "link": (LINK_CAPACITY,), "link_rest": (LINK_CAPACITY,),
            "link_stiffness": (LINK_CAPACITY,), "link_strength": (LINK_CAPACITY,),
            "link_slot": (LINK_CAPACITY, 4),
            "anchor": (n_anchor,), "anchor_point": (n_anchor,), "anchor_stiffness": (n_anchor,),
            "anchor_strength": (n_anchor,),
            "ring": (2, n_ring, n_around), "n_ring": (2,), "ring_joined": (2, n_ring),
            "ring_centre": (2, n_ring), "tube_radius": (2,),
            "row": (n_vertex + 1,), "column": (18 * n_vertex,), "block": (18 * n_vertex,),
        }  # fmt: skip
        self.arrays = TissueArrays()
        for name, var in TissueArrays.vars.items():
            shape = (n_env, *sizes.get(name, (n_vertex,)))
            setattr(self.arrays, name, wp.zeros(shape, dtype=var.type.dtype, device=self.device))
        self.shapes = ToolShapes()
        for name, var in ToolShapes.vars.items():
            shape = (n_env, N_SHAPES)
            setattr(self.shapes, name, wp.zeros(shape, dtype=var.type.dtype, device=self.device))
        self.shapes.a.numpy()[:] = 1.0  # far away until placed
        self.shapes.b.numpy()[:] = 1.0
        self.shapes.T_world_link.numpy()[:] = np.eye(4)

    def _fill(self, b: int, organ: Organ, scale: float) -> None:
        n, n_tet = len(organ.vertices), len(organ.tets)
        mu, lam = lame_of(organ.region, REGIONS, scale)
        set_row = self._set_row
        set_row("n_vertex", b, n)
        set_row("n_tet", b, n_tet)
        set_row("position", b, organ.vertices)
        set_row("rest", b, organ.vertices)
        set_row("fixed", b, organ.fixed)
        set_row("contact_shape", b, np.full(self.host("position").shape[1], -1))
        set_row("tet", b, organ.tets)
        set_row("tet_alive", b, np.ones(n_tet))
        self._shape_elements(b, np.arange(n_tet))
        set_row("mu", b, mu)
        set_row("lam", b, lam)
        set_row("tie_corner", b, np.column_stack([organ.tie_vertex, organ.tie_corners]))
        set_row("tie_weight", b, np.insert(-organ.tie_weights, 0, 1.0, axis=1))
        set_row("tie_stiffness", b, np.full(len(organ.tie_vertex), TIE_STIFFNESS))
        set_row("tie_strength", b, np.full(len(organ.tie_vertex), TIE_STRENGTH))
        set_row("anchor", b, organ.bed_vertices)
        set_row("anchor_point", b, organ.vertices[organ.bed_vertices])
        set_row("anchor_stiffness", b, np.full(len(organ.bed_vertices), ANCHOR_STIFFNESS))
        set_row("anchor_strength", b, np.full(len(organ.bed_vertices), ANCHOR_STRENGTH))
        for name in ("point_m", "normal", "along", "edge_m"):
            set_row("bed_" + name.removesuffix("_m"), b, getattr(organ.bed, name))
        for k, tube in enumerate(TUBES):
            self._fill_tube(b, k, organ, tube)
        if len(organ.remnants):
            ends = organ.vertices[organ.remnants]
            rest = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
            self.add_links(b, organ.remnants, rest_m=rest, stiffness=REMNANT_STIFFNESS,
                           strength_n=REMNANT_STRENGTH)  # fmt: skip

    def _fill_tube(self, b: int, k: int, organ: Organ, tube: str) -> None:
        rings = organ.rings[tube]
        n_around = (rings.shape[1] - 1) // 2
        self.host("ring")[b, k, : len(rings)] = rings[:, 1 + n_around :]
        self.host("n_ring")[b, k] = organ.neck_ring[tube] + 1
        self.host("ring_joined")[b, k, : organ.neck_ring[tube]] = 1
        radii = np.linalg.norm(
            organ.vertices[rings[:, 1 + n_around]] - organ.vertices[rings[:, 0]], axis=1
        )
        self.host("tube_radius")[b, k] = radii.mean()

    def _set_row(self, name: str, b: int, value: NDArray | float) -> None:
        array = self.host(name)
        if array.ndim == 1:
            array[b] = value
        else:
            array[b, : len(np.asarray(value))] = value

    def _weigh(self, b: int) -> None:
        """Lump each living element's mass on its corners."""
        tets = self.tets(b)
        quarter = DENSITY_KG_M3 * self.host("volume")[b, : len(tets)] / 4.0
        quarter = np.where(self.host("tet_alive")[b, : len(tets)] != 0, quarter, 1.0e-12)
        n = self.n_vertex(b)
        self.host("mass")[b, :n] = np.bincount(
            tets.ravel(), weights=np.repeat(quarter, 4), minlength=n
        )

    def _record(self) -> None:
        """Prepare the kernel launches of a step, in order."""
        c, t, n_env = self.config, self.arrays, len(self.organs)
        plan = {
            "predict": (implicit.begin_step, [t, c.step_s]),
            "elements": (elasticity.assemble_elements, [t]),
            "springs": (springs.assemble_springs, [t]),
            "tube contact": (contact.assemble_tube_contact, [t]),
            "tool and bed contact": (contact.assemble_surface_contact, [t, self.shapes]),
            "solve": (
                implicit.solve_step,
                [t, c.step_s, c.damping_per_s, wp.vec3(*c.gravity_m_s2), c.iterations, c.tolerance],
            ),
            "breakage": (springs.break_springs, [t]),
            "reactions": (contact.tool_reactions, [t, self.shapes]),
        }
        self.stages: dict[str, wp.Launch] = {
            name: wp.launch(kernel, dim=n_env, inputs=inputs, device=self.device, record_cmd=True)
            for name, (kernel, inputs) in plan.items()
        }
