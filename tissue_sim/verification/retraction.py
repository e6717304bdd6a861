"""How far the stepped tissue is from the converged static solution after a retraction.

The infundibulum is grasped and drawn off the liver and sideways, then held. Grasped vertices are
moved, not pulled: the answer is the tissue's alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissue_sim.field import RIGHT
from tissue_sim.frames import Array
from tissue_sim.organ import Organ
from tissue_sim.tissue import Tissue, TissueConfig
from tissue_sim.verification.statics import displaced, equilibrium, statics_of

GRASPED_M = 0.005  # from the middle of the infundibulum: as wide as a grasper
GRASPED_SHARE = 0.6  # of the way along the infundibulum
SIDEWAYS = 0.5  # share of the pull; the rest is off the liver
INCREMENTS = 8  # of the static solution
SPRINGS = ("tie_stiffness", "link_stiffness", "anchor_stiffness")


@dataclass(frozen=True, kw_only=True)
class Retraction:
    """Errors of the positions against the converged static solution.

    Attributes:
        tets: tetrahedra of the mesh.
        shift_m: how far the grasp was moved.
        held_s: (n,), times since the motion ended.
        largest_m: (n,), largest distance of a vertex from its place at rest.
        rms_m: (n,), root mean square of the distances.
        broken: springs that broke on the way; the static solution is without them.
    """

    tets: int
    shift_m: float
    held_s: Array
    largest_m: Array
    rms_m: Array
    broken: int


def retraction(
    organ: Organ,
    stiffness_scale: float,
    config: TissueConfig,
    *,
    shift_m: float = 0.020,
    moving_s: float = 1.0,
    held_s: tuple[float, ...] = (0.0, 0.25, 0.5, 1.0, 2.0),
) -> Retraction:
    """Draw the grasped infundibulum smoothly, hold it, and compare with the static solution.

    The tubes must not touch each other: `statics_of` leaves that contact out.
    """
    tissue = Tissue([organ], stiffness_scale=[stiffness_scale], config=config)
    tissue.host("fixed")[0, : len(organ.vertices)] |= grasped(organ)
    whole = _springs(tissue)
    shift = shift_m * pull_direction(organ)
    snapshots = list(_drawn(tissue, organ, shift, moving_s, held_s))
    static = _static(tissue, organ, shift)
    errors = np.linalg.norm(np.array(snapshots) - static, axis=2)
    return Retraction(
        tets=len(organ.tets),
        shift_m=shift_m,
        held_s=np.array(held_s),
        largest_m=errors.max(axis=1),
        rms_m=np.sqrt((errors**2).mean(axis=1)),
        broken=whole - _springs(tissue),
    )


def grasped(organ: Organ) -> NDArray[np.bool_]:
    """(n_vertex,), the sac's vertices near the middle of the infundibulum."""
    neck = organ.sac_rings[0, 0]
    axis = organ.vertices[organ.sac_rings[:, 0]]
    along = np.linalg.norm(axis - organ.vertices[neck], axis=1)
    middle = axis[np.argmin(np.abs(along - GRASPED_SHARE * 0.015))]
    near = np.linalg.norm(organ.vertices - middle, axis=1) < GRASPED_M
    near &= np.isin(np.arange(len(near)), organ.sac_rings)
    return near


def pull_direction(organ: Organ) -> Array:
    """Unit vector off the liver and to the surgeon's right."""
    return SIDEWAYS * RIGHT + np.sqrt(1 - SIDEWAYS**2) * organ.bed.normal


def _drawn(
    tissue: Tissue, organ: Organ, shift: Array, moving_s: float, held_s: tuple[float, ...]
) -> Iterator[Array]:
    """Positions at the times since the motion's end."""
    held = np.flatnonzero(grasped(organ))
    h = tissue.config.step_s
    ends = [round((moving_s + t) / h) for t in held_s]
    for k in range(1, ends[-1] + 1):
        t = min(k * h / moving_s, 1.0)
        tissue.positions()[held] = organ.vertices[held] + t * t * (3 - 2 * t) * shift
        tissue.step()
        if k in ends:
            yield tissue.positions().astype(float)


def _static(tissue: Tissue, organ: Organ, shift: Array) -> Array:
    """The rest position under gravity, then the grasp's shift, with the springs still whole."""
    statics = statics_of(tissue)
    hanging = equilibrium(statics, tissue.host("rest")[0, : tissue.n_vertex()])
    moved = np.where(grasped(organ)[:, None], shift, 0.0)
    return displaced(statics, hanging, moved, increments=INCREMENTS)


def _springs(tissue: Tissue) -> int:
    return sum(int((tissue.host(name) > 0).sum()) for name in SPRINGS)
