"""Manage the tissue of a batch of environments: allocate, step, rewire, save and restore."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.mechanics import assembly, elasticity, rupture, springs
from tissue_sim.mechanics.arrays import STATE, TissueArrays, ToolShapes
from tissue_sim.mechanics.bar_contact import N_BARS, Bar
from tissue_sim.mechanics.coarse_motion import skyline
from tissue_sim.mechanics.layout import (
    HOST,
    LINK_CAPACITY,
    allocate,
    require_sound_organ,
    starting_values,
)
from tissue_sim.mechanics.step import STAGES, TissueConfig, step_parameters, take_stages
from tissue_sim.mechanics.topology import (
    block_pattern,
    boundary_faces,
    components,
    inverse_edges,
    on_corners,
)
from tissue_sim.patient.material import DENSITY_KG_M3, REMNANT_STIFFNESS, REMNANT_STRENGTH
from tissue_sim.patient.mesher import Indices, signed_volumes
from tissue_sim.patient.organ import REGIONS, Organ


class Tissue:
    """Finite-element tissue of one or more environments, stepped together on the CPU."""

    def __init__(
        self,
        organs: Sequence[Organ],
        *,
        stiffness_scale: Sequence[float] | None = None,
        config: TissueConfig | None = None,
    ) -> None:
        self.config = config or TissueConfig()
        self.organs = tuple(organs)
        for organ in self.organs:
            require_sound_organ(organ)
        scales = stiffness_scale or [1.0] * len(self.organs)
        self.arrays, self.shapes = allocate(self.organs)
        self._views = _views(self.arrays, TissueArrays)
        self._tools = _views(self.shapes, ToolShapes)
        for b, (organ, scale) in enumerate(zip(self.organs, scales, strict=True)):
            self._fill(b, organ, scale)
            self.rewire(b)
        self._prepare_launches()

    def host(self, name: str) -> NDArray:
        """Return an array of `arrays` as a numpy array that shares its memory."""
        return self._views[name]

    def positions(self, b: int = 0) -> Array:
        """Return the (n_vertex, 3) positions of one environment, m."""
        return self.host("position")[b, : self.n_vertex(b)]

    def n_vertex(self, b: int = 0) -> int:
        """Return the number of vertices in use."""
        return int(self.host("n_vertex")[b])

    def spare_vertices(self, b: int = 0) -> int:
        """Return the number of vertices that can still be added."""
        return self.host("position").shape[1] - self.n_vertex(b)

    def tets(self, b: int = 0) -> NDArray[np.int32]:
        """Return the (n_tet, 4) corners, including severed parts and dead elements."""
        return self.host("tet")[b, : len(self.organs[b].tets)]

    def step(self) -> None:
        """Advance every environment by one step of `config.step_s`."""
        self._step.launch()
        self._rewire_broken()

    def step_in_stages(self) -> None:
        """Advance one step with one launch per stage, so that a stage can be timed or left out."""
        for launch in self.stages.values():
            launch.launch()
        self._rewire_broken()

    def load_walls(self) -> None:
        """Compute `segment_pull` and `patch_stretch` at the current positions."""
        self._walls.launch()

    def place_tools(self, env: int, **values: Array) -> None:
        """Set the poses of the instruments' contact shapes.

        Args:
            env: Number of the environment.
            values: Arrays (8, ...) by field name of `ToolShapes`, world frame. Without
                `T_world_link_before` the shapes do not move in this step and sweep over nothing.
        """
        values.setdefault("T_world_link_before", values["T_world_link"])
        for name, value in values.items():
            self._tools[name][env] = value

    def place_bars(self, b: int, bars: Sequence[Bar]) -> None:
        """Let tissue carry rigid bars in place of earlier bars; of too many bars, keep the last.

        Args:
            b: Number of the environment.
            bars: The bars.
        """
        bars = bars[-N_BARS:]
        self.host("n_bar")[b] = len(bars)
        for k, bar in enumerate(bars):
            n = len(bar.vertices)
            self.host("bar_reach")[b, k], self.host("bar_radius")[b, k] = bar.reach_m, bar.radius_m
            self.host("bar_count")[b, k], self.host("bar_in_jaws")[b, k] = n, bar.in_jaws
            self.host("bar_vertex")[b, k, :n] = bar.vertices
            self.host("bar_middle")[b, k, :n] = bar.middle
            self.host("bar_axis")[b, k, :n] = bar.axis

    def T_world_links(self, b: int = 0) -> Array:
        """Return the (8, 4, 4) poses of the instruments' links at the last placement."""
        return self._tools["T_world_link"][b].copy()

    def tool_axes(self, b: int = 0) -> tuple[Array, Array]:
        """Return the near and far ends (8, 3) of the contact shapes' axes at the last placement."""
        return self._tools["a"][b], self._tools["b"][b]

    def tool_wrenches(self, b: int = 0) -> tuple[Array, Array]:
        """Return force (8, 3) N and torque (8, 3) N m on the tools, about each link's origin."""
        return self._tools["force"][b], self._tools["torque"][b]

    def add_links(
        self,
        b: int,
        pairs: NDArray[np.integer],
        *,
        rest_m: Array,
        stiffness: Array | float,
        strength_n: float,
    ) -> NDArray[np.int64]:
        """Add springs between pairs (n, 2) of vertices and return their rows; call `rewire` next.

        Raises:
            ValueError: no room is left.
        """
        stiff = self.host("link_stiffness")[b]
        free = np.flatnonzero(stiff == 0.0)[: len(pairs)]
        if len(free) < len(pairs):
            raise ValueError(
                f"tissue: no room for {len(pairs)} links; the capacity is {LINK_CAPACITY}"
            )
        self.host("link")[b, free] = pairs
        self.host("link_rest")[b, free] = rest_m
        self.host("link_strength")[b, free] = strength_n
        stiff[free] = stiffness
        return free

    def duplicate(self, b: int, parents: Sequence[int]) -> None:
        """Append a copy of each parent vertex, with position and velocity; call `rewire` next.

        Raises:
            ValueError: there are fewer spare vertices; nothing has changed.
        """
        n = self.n_vertex(b)
        if len(parents) > self.spare_vertices(b):
            raise ValueError(
                f"tissue: no room for {len(parents)} vertices; {self.spare_vertices(b)} are left"
            )
        new = slice(n, n + len(parents))
        for name in ("position", "rest", "velocity"):
            values = self.host(name)
            values[b, new] = values[b, list(parents)]
        self.host("contact_shape")[b, new] = -1
        self.host("n_vertex")[b] = n + len(parents)
        self._new_part(b, new)

    def _new_part(self, b: int, vertices: slice) -> None:
        """Make these vertices one part in the preconditioner, or no part if none is left."""
        n = int(self.host("n_part")[b])
        has_room = n < self.host("part_count").shape[1]
        self.host("part")[b, vertices] = n if has_room else -1
        self.host("n_part")[b] = n + has_room

    def slide(self, b: int, vertices: Indices, towards: Indices, share: float) -> None:
        """Move vertices along edges towards others by a share, at rest and at present."""
        for name in ("position", "velocity", "rest"):
            values = self.host(name)[b]
            values[vertices] += share * (values[towards] - values[vertices])
        around = np.flatnonzero(np.isin(self.tets(b), vertices).any(axis=1))
        self._shape_elements(b, around)

    def _shape_elements(self, b: int, elements: NDArray[np.integer]) -> None:
        """Compute rest shape matrices and volumes from the rest positions."""
        rest = self.host("rest")[b].astype(np.float64)
        tets = self.tets(b)[elements]
        self.host("rest_inverse")[b, elements] = inverse_edges(rest, tets)
        self.host("volume")[b, elements] = signed_volumes(rest, tets)

    def pattern(
        self, b: int, n_vertex: int, tets: Indices, links: Indices
    ) -> tuple[Indices, Indices, list[Indices]]:
        """Return the matrix pattern (`block_pattern`) of a topology: elements, ties, links.

        Raises:
            ValueError: the pattern has more blocks than the capacity.
        """
        row, column, slots = block_pattern(n_vertex, [tets, self.host("tie_corner")[b], links])
        if len(column) >= self.host("column").shape[1]:
            raise ValueError("tissue: the stiffness matrix exceeds its capacity")
        return row, column, slots

    def rewire(self, b: int) -> None:
        """Rebuild all that follows from the topology and from the ties and anchors that hold."""
        n, tets = self.n_vertex(b), self.tets(b)
        self._lump_masses(b)
        self._fix_vertices(b)
        self._find_held(b)
        row, column, (tet, tie, link) = self.pattern(b, n, tets, self.host("link")[b])
        self.host("row")[b, : n + 1] = row
        self.host("column")[b, : len(column)] = column
        n_part = int(self.host("n_part")[b])
        first, start = skyline(n_part, self.host("part")[b], row, column)
        self.host("factor_first")[b, :n_part] = first
        self.host("factor_start")[b, : n_part + 1] = start
        self.host("tet_slot")[b, : len(tet)] = tet
        self.host("tie_slot")[b] = tie
        self.host("link_slot")[b] = link
        self.host("stiffness_holds")[b] = 0
        alive = self.host("tet_alive")[b, : len(tets)] != 0
        faces, _ = boundary_faces(tets[alive])
        surface = self.host("surface")[b]
        surface[:] = 0
        surface[np.unique(faces)] = 1
        surface[self.host("covered")[b] != 0] = 0
        surface[self._tied_vertices(b)] = 0
        surface[tets[self._in_lumen(b)]] = 0
        self.host("contact_shape")[b, surface == 0] = -1

    def _tied_vertices(self, b: int) -> Indices:
        """Return tube vertices tied into a wall; tools touch the wall instead of these vertices."""
        tied = self.host("tie_stiffness")[b] > 0.0
        return self.host("tie_corner")[b][tied, 0]

    def _in_lumen(self, b: int) -> NDArray[np.bool_]:
        """Return (n_tet,) whether an element fills a tube.

        Tools touch a tube's end by its outer vertices alone. If tools touched the filling too, a
        finger could separate an end's wall from its filling.
        """
        region = self.organs[b].region
        return (region % 2 == 1) & (region > REGIONS.index("bile"))

    def _rewire_broken(self) -> None:
        """Rewire where a tie or an anchor broke in this step."""
        broken = self.host("has_broken")
        for b in np.flatnonzero(broken).tolist():
            broken[b] = 0
            self.rewire(b)

    def _find_held(self, b: int) -> None:
        """Find the pieces that the body holds; remove the others from the preconditioner's parts.

        A strand supports nothing, because it may break at any time. The pieces' inertia is a
        millionth of their stiffness, less than the matrix's rounding errors. In the rigid motion of
        such a part, the solver would compute only these errors.
        """
        n, host = self.n_vertex(b), self.host
        label = components(n, self.tets(b)[host("tet_alive")[b, : len(self.tets(b))] != 0])
        held = [
            np.flatnonzero(self.organs[b].fixed),
            host("tie_corner")[b, host("tie_stiffness")[b] > 0.0].ravel(),
            host("anchor")[b, host("anchor_stiffness")[b] > 0.0],
        ]
        is_held = np.isin(label, label[np.concatenate(held)])
        host("held")[b, :n] = is_held
        host("part")[b, :n][~is_held] = -1

    def state(self) -> dict[str, NDArray]:
        """Return a copy of all arrays that change, including the topology."""
        return {name: part.copy() for name, part in self.parts().items()}

    def parts(self) -> dict[str, NDArray]:
        """Return the arrays that `state` copies."""
        return {name: self.host(name) for name in STATE}

    def restore(self, state: dict[str, NDArray]) -> None:
        """Restore what `state` of this tissue returned; `World.check` validates a state first."""
        for name in STATE:
            self.host(name)[:] = state[name]
        for b in range(len(self.organs)):
            self.rewire(b)
        self.host("stiffness_holds")[:] = state["stiffness_holds"]
        self._restore_stiffness.launch()

    def elastic_energy_j(self) -> Array:
        """Return the (n_env,) elastic energy of elements and springs."""
        total = np.zeros(len(self.organs))
        for kernel in (elasticity.elastic_energy, springs.spring_energy):
            out = wp.zeros(len(self.organs), dtype=wp.float64, device=HOST)
            wp.launch(kernel, dim=len(self.organs), inputs=[self.arrays, out], device=HOST)
            total += out.numpy()
        return total

    def volumes(self, b: int = 0) -> Array:
        """Return the (n_tet,) current volumes of the elements, m^3; negative when inverted."""
        return signed_volumes(self.positions(b).astype(np.float64), self.tets(b))

    def _fill(self, b: int, organ: Organ, stiffness_scale: float) -> None:
        for name, value in starting_values(organ, stiffness_scale).items():
            self.host(name)[(b, *(slice(n) for n in value.shape))] = value
        self._shape_elements(b, np.arange(len(organ.tets)))
        if len(organ.remnants):
            ends = organ.vertices[organ.remnants]
            self.add_links(
                b,
                organ.remnants,
                rest_m=np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1),
                stiffness=REMNANT_STIFFNESS,
                strength_n=REMNANT_STRENGTH,
            )

    def _lump_masses(self, b: int) -> None:
        """Lump each living element's mass on its corners."""
        tets = self.tets(b)
        quarter = DENSITY_KG_M3 * self.host("volume")[b, : len(tets)] / 4.0
        quarter = np.where(self.host("tet_alive")[b, : len(tets)] != 0, quarter, 1.0e-12)
        n = self.n_vertex(b)
        self.host("mass")[b, :n] = on_corners(tets, quarter, n)

    def _fix_vertices(self, b: int) -> None:
        """Fix vertices that the body or a clamp holds, and vertices without living elements.

        Vertices without elements would fall for ever; nothing stays tied or anchored to them.
        """
        tets, fixed = self.tets(b), self.host("fixed")[b]
        lone = np.ones(len(fixed), bool)
        lone[tets[self.host("tet_alive")[b, : len(tets)] != 0]] = False
        fixed[:] = lone | (self.host("clamped")[b] != 0)
        fixed[: len(self.organs[b].fixed)] |= self.organs[b].fixed
        self.host("tie_stiffness")[b, lone[self.host("tie_corner")[b]].any(axis=1)] = 0.0
        self.host("anchor_stiffness")[b, lone[self.host("anchor")[b]]] = 0.0

    def _prepare_launches(self) -> None:
        """Prepare the kernel launches."""
        self._step = self._prepared(take_stages, *self._arguments(0, len(STAGES)))
        self.stages: dict[str, Any] = {
            name: self._prepared(take_stages, *self._arguments(k, k + 1))
            for k, name in enumerate(STAGES)
        }
        viscosity = step_parameters(self.config).viscosity
        self._restore_stiffness = self._prepared(assembly.restore_stiffness, self.arrays, viscosity)
        self._walls = self._prepared(rupture.load_walls, self.arrays)

    def _arguments(self, first: int, end: int) -> tuple[Any, ...]:
        return self.arrays, self.shapes, step_parameters(self.config), first, end

    def _prepared(self, kernel: Any, *inputs: Any) -> Any:
        n_env = len(self.organs)
        return wp.launch(kernel, dim=n_env, inputs=inputs, device=HOST, record_cmd=True)


def _views(arrays: Any, struct: Any) -> dict[str, NDArray]:
    return {name: getattr(arrays, name).numpy() for name in struct.vars}
