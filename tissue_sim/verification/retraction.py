"""Compare stepped tissue with the converged static solution after a retraction.

The infundibulum is grasped, pulled off the liver and sideways, then held. Grasped vertices are
displaced, not pulled by a force, so the result depends on the tissue alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import RIGHT, Array
from tissue_sim.mechanics.step import TissueConfig
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.organ import INFUNDIBULUM_M, Organ
from tissue_sim.verification.statics import displaced, equilibrium, statics_of

GRASPED_M = 0.005  # radius about the middle of the infundibulum: the width of a grasper
GRASPED_SHARE = 0.6  # place along the infundibulum
SIDEWAYS = 0.5  # share of the pull; the rest is away from the liver
INCREMENTS = 8  # steps of the static solution
TIGHT = {
    "iterations": 400,
    "tolerance": 1e-5,
    "settled_j": 0.0,
}  # with these settings the solver causes no remaining error
MAX_ERROR_M = 1e-4  # a tenth of the thinnest tube's radius
SPRINGS = ("tie_stiffness", "link_stiffness", "anchor_stiffness")


@dataclass(frozen=True, kw_only=True)
class Retraction:
    """Errors of the positions against the converged static solution.

    Attributes:
        tets, vertices: Sizes of the mesh.
        shift_m: Displacement of the grasp.
        held_s: (n,), times since the motion ended.
        largest_m: (n,), largest distance of a vertex from its static position.
        rms_m: (n,), root mean square of the distances.
        lag_m: (n,), the largest distance with a tight solver: inertia and viscosity alone.
        broken: Number of springs that broke; the static solution has no broken springs.
        static_m: (n_vertex, 3), the static solution.
    """

    tets: int
    vertices: int
    shift_m: float
    held_s: Array
    largest_m: Array
    rms_m: Array
    lag_m: Array
    broken: int
    static_m: Array


def retraction(
    organ: Organ,
    stiffness_scale: float,
    config: TissueConfig,
    *,
    shift_m: float = 0.020,
    moving_s: float = 1.0,
    held_s: Sequence[float] = (0.0, 0.25, 0.5, 1.0, 2.0),
) -> Retraction:
    """Pull the grasped infundibulum smoothly, hold it, and compare with the static solution.

    Raises:
        ArithmeticError: a tube touches another tube or the gallbladder, which `statics_of` leaves
            out; or the static solution does not converge.
    """
    shift = shift_m * pull_direction(organ)
    tight = _grasped_tissue(organ, stiffness_scale, replace(config, **TIGHT))
    exact = list(_pull_and_hold(tight, shift, moving_s, held_s))
    tissue = _grasped_tissue(organ, stiffness_scale, config)
    whole = _springs(tissue)
    positions = list(_pull_and_hold(tissue, shift, moving_s, held_s))
    broken = whole - _springs(tissue)
    static = _static(tissue, shift)
    errors, lags = (np.linalg.norm(np.array(x) - static, axis=2) for x in (positions, exact))
    return Retraction(
        tets=len(organ.tets),
        vertices=len(organ.vertices),
        shift_m=shift_m,
        held_s=np.array(held_s),
        largest_m=errors.max(axis=1),
        rms_m=np.sqrt((errors**2).mean(axis=1)),
        lag_m=lags.max(axis=1),
        broken=broken,
        static_m=static,
    )


def grasped(organ: Organ) -> NDArray[np.bool_]:
    """Return (n_vertex,) whether a vertex belongs to the sac near the infundibulum's middle."""
    neck = organ.sac_rings[0, 0]
    axis = organ.vertices[organ.sac_rings[:, 0]]
    along = np.linalg.norm(axis - organ.vertices[neck], axis=1)
    middle = axis[np.argmin(np.abs(along - GRASPED_SHARE * INFUNDIBULUM_M))]
    near = np.linalg.norm(organ.vertices - middle, axis=1) < GRASPED_M
    near &= np.isin(np.arange(len(near)), organ.sac_rings)
    return near


def pull_direction(organ: Organ) -> Array:
    """Return the unit vector off the liver and to the surgeon's right."""
    return SIDEWAYS * RIGHT + np.sqrt(1 - SIDEWAYS**2) * organ.bed.normal


def _grasped_tissue(organ: Organ, stiffness_scale: float, config: TissueConfig) -> Tissue:
    held = replace(organ, fixed=organ.fixed | grasped(organ))
    return Tissue([held], stiffness_scale=[stiffness_scale], config=config)


def _pull_and_hold(
    tissue: Tissue, shift: Array, moving_s: float, held_s: Sequence[float]
) -> Iterator[Array]:
    """Yield the positions at the times since the motion's end."""
    (organ,) = tissue.organs
    held = np.flatnonzero(grasped(organ))
    h = tissue.config.step_s
    ends = [round((moving_s + t) / h) for t in held_s]
    for k in range(1, ends[-1] + 1):
        t = min(k * h / moving_s, 1.0)
        tissue.positions()[held] = organ.vertices[held] + t * t * (3 - 2 * t) * shift
        tissue.step()
        if k in ends:
            yield tissue.positions().astype(float)


def _static(tissue: Tissue, shift: Array) -> Array:
    """Return the static solution under gravity and the grasp's shift, without broken springs."""
    if _tubes_touch(tissue):
        raise ArithmeticError(
            "a tube touches another one or the gallbladder: the static solution leaves this out"
        )
    statics = statics_of(tissue)
    hanging = equilibrium(statics, tissue.host("rest")[0, : tissue.n_vertex()])
    moved = np.where(grasped(tissue.organs[0])[:, None], shift, 0.0)
    return displaced(statics, hanging, moved, increments=INCREMENTS)


def _tubes_touch(tissue: Tissue) -> bool:
    """Return whether a tube touches another tube or the gallbladder."""
    for stage in ("predict", "tube contact"):
        tissue.stages[stage].launch()
    return bool(tissue.host("force").any())


def _springs(tissue: Tissue) -> int:
    return sum(int((tissue.host(name) > 0).sum()) for name in SPRINGS)
