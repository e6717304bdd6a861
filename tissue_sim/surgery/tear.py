"""Tear a tube at its weakest section under too strong a pull.

The mesh's walls are thicker and softer than the real walls. The limit is therefore a force: the
real wall's ultimate strength times its section.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.patient.tubes import Tubes
from tissue_sim.patient.walls import strength_n
from tissue_sim.surgery.parting import Opening, part_ring


@dataclass(frozen=True, kw_only=True)
class Load:
    """The segment of a tube that is nearest to its ultimate strength.

    Attributes:
        segment: Number of the segment, which is the number of the ring below it.
        pull_n: Pull along the tube.
        holds_n: Pull at which the segment tears.
    """

    tube: str
    segment: int
    pull_n: float
    holds_n: float


@dataclass(frozen=True, kw_only=True)
class Tear(Opening):
    """A tube pulled in two, with the pull and the wall's strength, N."""

    pull_n: float
    holds_n: float


def worst_load(tubes: Tubes, tube: str) -> Load:
    """Return the load nearest to a tear among the loads that `Tissue.load_walls` found.

    A real pull acts on neighbouring segments too. A load on one segment alone comes from jaws that
    deform it.
    """
    whole_n = strength_n(tube, tubes.radius_m(tube))
    pulls = tubes.tissue.host("segment_pull")[tubes.b, tubes.organ.hollow.index(tube)]
    if not pulls.any():
        return Load(tube=tube, segment=0, pull_n=0.0, holds_n=whole_n)
    around = np.concatenate([[0.0], pulls[: tubes.organ.neck_ring[tube]], [0.0]])
    pulls = np.minimum(around[1:-1], np.maximum(around[:-2], around[2:]))
    share = intact_share(tubes, tube)
    holds_n = whole_n * np.minimum(share[:-1], share[1:])[: len(pulls)]
    k = int(np.argmax(pulls / holds_n))
    return Load(tube=tube, segment=k, pull_n=float(pulls[k]), holds_n=float(holds_n[k]))


def tear(tubes: Tubes, load: Load, *, time_s: float) -> Tear | None:
    """Split the tube at the overloaded segment; return None if no ring there can be split.

    A clip holds its rings together, so the tube tears beside the clip.
    """
    tube, rings = load.tube, tubes.below[load.tube]
    free = _can_part(tubes, tube)
    if not free.any():
        return None
    # of two equally near rings, choose the weaker
    distance = np.abs(np.arange(len(free)) - load.segment - 0.5) + 0.1 * intact_share(tubes, tube)
    ring = int(np.argmin(np.where(free, distance, np.inf)))
    if not part_ring(tubes, tube, ring, np.ones(rings.shape[1], bool)):
        return None
    return Tear(
        tube=tube,
        time_s=time_s,
        ring=ring,
        station_m=float(tubes.stations_m[tube][ring]),
        pull_n=load.pull_n,
        holds_n=load.holds_n,
    )


def intact_share(tubes: Tubes, tube: str) -> Array:
    """Return the (n_ring,) share of the wall that a cut has left; 1 again at a stump's end."""
    same = (tubes.above[tube] == tubes.below[tube])[:, 1:]
    if same.all():
        return np.ones(len(same))
    joined = same.mean(axis=1)
    return np.where(joined > 0.0, joined, 1.0)


def _can_part(tubes: Tubes, tube: str) -> NDArray[np.bool_]:
    """Return (n_ring,) whether a ring is neither severed nor clipped nor held by body or sac."""
    ring = np.arange(len(tubes.below[tube]))
    free = (ring > 0) & (ring < tubes.organ.neck_ring[tube])
    free[tubes.severed_rings(tube)] = False
    return free & ~tubes.tissue.host("covered")[tubes.b, tubes.below[tube]].any(axis=1)
