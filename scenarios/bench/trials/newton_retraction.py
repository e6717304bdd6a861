"""The same retraction for two solvers: the organ's infundibulum is pulled up.

The organ's tetrahedra have the same Lame parameters and density in both solvers. Both solvers hold
the same vertices: the far ends of the tubes and those on the liver. Newton has no ties into a
tetrahedron, so in both solvers four springs to its corners replace each tie.

Two differences remain. Newton's elements are stable neo-Hookean, Calot's are fixed-corotated.
Calot's elements are damped, Newton's are not: Newton's damping (1 to 100 Pa s tried) costs time and
does not bring the tissue closer to rest. Nothing is in contact, but Calot's solver still checks for
contact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import warp as wp
from numpy.typing import NDArray

from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import UP, Array
from tissue_sim.mechanics.tissue import Tissue, TissueConfig
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.at_risk import AT_RISK, BRANCHES
from tissue_sim.patient.material import DENSITY_KG_M3, TIE_STIFFNESS, lame_of
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import REGIONS, Organ, build_organ

RETRACTION_M = 0.020
DRAWN_STEPS = 30  # control steps of retraction; then hold
GRASPED_RINGS = slice(2, 5)  # of the infundibulum
MIN_WEIGHT = 0.01  # of a corner in a tie; a smaller one gets no spring


@dataclass(frozen=True, kw_only=True)
class RetractedBody:
    """Input of both solvers.

    Attributes:
        organ: Mesh and regions.
        stiffness_scale: The patient's stiffness scale.
        held: (n_vertex,), fixed except for the retraction.
        drawn: The vertices that are pulled up.
        springs: (n, 2), pairs of vertices, at rest at their initial distance.
        spring_stiffness: (n,), N/m.
    """

    organ: Organ
    stiffness_scale: float
    held: NDArray[np.bool_]
    drawn: Indices
    springs: Indices
    spring_stiffness: Array


@dataclass(frozen=True, kw_only=True)
class Solver:
    """A solver with the body loaded.

    Attributes:
        name: Name for people to read.
        step: Makes one control step. Its arguments are the drawn vertices' first and last height
            (m).
        positions: Returns the vertices (n, 3), m.
    """

    name: str
    step: Callable[[float, float], None]
    positions: Callable[[], NDArray]


def height_m(step: int) -> float:
    """Return the height of the infundibulum at the start of a control step."""
    return RETRACTION_M * min(step / DRAWN_STEPS, 1.0)


def body_of(anatomy: Anatomy) -> RetractedBody:
    """Return the organ held at trunks, liver and grasper, with springs for the sac's ties."""
    organ = build_organ(anatomy)
    drawn = organ.sac_rings[GRASPED_RINGS].ravel()
    held = organ.fixed.copy()
    held[organ.anchored] = held[drawn] = True
    held[np.concatenate([organ.rings[part].ravel() for part in AT_RISK])] = True
    held[np.concatenate([organ.rings[branch][0] for branch in BRANCHES.values()])] = True
    weights = np.maximum(organ.tie_weights, 0.0)
    tie, corner = np.nonzero(weights > MIN_WEIGHT)
    return RetractedBody(
        organ=organ,
        stiffness_scale=anatomy.stiffness_scale,
        held=held,
        drawn=drawn,
        springs=np.stack([organ.tie_vertex[tie], organ.tie_corners[tie, corner]], axis=1),
        spring_stiffness=TIE_STIFFNESS * weights[tie, corner],
    )


def in_calot(body: RetractedBody, config: TissueConfig) -> Solver:
    """Load the body into Calot's tissue."""
    none = np.zeros((0, 4), np.int32)
    organ = replace(
        body.organ,
        fixed=body.held,
        tie_vertex=none[:, 0],
        tie_corners=none,
        tie_weights=none.astype(float),
        bed_vertices=none[:, 0],
        ligament_vertices=none[:, 0],
        remnants=none[:, :2],
        bed=replace(body.organ.bed, point_m=-body.organ.bed.normal),  # out of reach
    )
    tissue = Tissue([organ], stiffness_scale=[body.stiffness_scale], config=config)
    ends = organ.vertices[body.springs]
    tissue.add_links(
        0,
        body.springs,
        rest_m=np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1),
        stiffness=body.spring_stiffness,
        strength_n=np.inf,
    )
    tissue.rewire(0)
    substeps = round(CONTROL_PERIOD_S / config.step_s)

    def step(before_m: float, after_m: float) -> None:
        for drawn_m in np.linspace(before_m, after_m, substeps + 1)[1:]:
            tissue.positions()[body.drawn] = organ.vertices[body.drawn] + drawn_m * UP
            tissue.step()

    return Solver(name=f"Calot, {substeps} implicit steps", step=step, positions=tissue.positions)


def in_newton(body: RetractedBody, *, substeps: int, iterations: int) -> Solver:
    """Load the body into Newton's SolverVBD, with a control step as a captured graph.

    Args:
        body: The body.
        substeps: Number in a control step; even, because two states alternate.
        iterations: Number in a substep.
    """
    from newton.solvers import SolverVBD  # pyright: ignore[reportMissingImports]

    model = _newton_model(body)
    solver = SolverVBD(model, iterations=iterations, particle_enable_tile_solve=False)
    begun, now, after = model.state(), model.state(), model.state()
    control, dt_s = model.control(), CONTROL_PERIOD_S / substeps
    device = model.device
    drawn = wp.array(body.drawn, dtype=int, device=device)
    motion = wp.zeros(2, dtype=wp.vec3, device=device)

    def substep(k: int, now, after) -> None:
        share = (k + 1) / substeps
        inputs = [drawn, begun.particle_q, motion, share, now.particle_q]
        wp.launch(draw_up, dim=len(drawn), inputs=inputs, device=device)
        solver.step(now, after, control, None, dt_s)

    substep(0, now, after)  # allocates, which a capture must not
    now.assign(begun)
    after.assign(begun)
    with wp.ScopedCapture(device=device) as capture:
        for k in range(substeps):
            substep(k, *((now, after) if k % 2 == 0 else (after, now)))

    def step(before_m: float, after_m: float) -> None:
        motion.numpy()[:] = np.outer([before_m, after_m], UP)
        wp.capture_launch(capture.graph)  # pyright: ignore[reportArgumentType]

    name = f"Newton's VBD, {substeps} x {iterations}"
    return Solver(name=name, step=step, positions=now.particle_q.numpy)


def _newton_model(body: RetractedBody):  # the type exists only where Newton is installed
    from newton import ModelBuilder  # pyright: ignore[reportMissingImports]

    organ = body.organ
    mu, lam = lame_of(organ.region, REGIONS, body.stiffness_scale)
    builder = ModelBuilder()
    builder.add_soft_mesh(
        pos=wp.vec3(),
        rot=wp.quat_identity(),
        scale=1.0,
        vel=wp.vec3(),
        vertices=[wp.vec3(*vertex) for vertex in organ.vertices],
        indices=organ.tets.ravel().tolist(),
        density=DENSITY_KG_M3,
        k_mu=mu,
        k_lambda=lam,
        k_damp=0.0,
        add_surface_mesh_edges=False,
    )
    for (i, j), stiffness in zip(body.springs.tolist(), body.spring_stiffness, strict=True):
        builder.add_spring(i, j, ke=float(stiffness), kd=0.0, control=0.0)
    for i in np.flatnonzero(body.held):
        builder.particle_mass[i] = 0.0  # Newton's way to hold a particle
    builder.color()
    return builder.finalize(device="cpu")


@wp.kernel
def draw_up(
    drawn: wp.array(dtype=int),  # pyright: ignore[reportInvalidTypeForm]
    rest: wp.array(dtype=wp.vec3),  # pyright: ignore[reportInvalidTypeForm]
    motion: wp.array(dtype=wp.vec3),  # pyright: ignore[reportInvalidTypeForm]
    share: float,
    position: wp.array(dtype=wp.vec3),  # pyright: ignore[reportInvalidTypeForm]
):
    """Move the drawn vertices a share of the way from the first to the second shift."""
    i = drawn[wp.tid()]
    position[i] = rest[i] + motion[0] + (motion[1] - motion[0]) * share
