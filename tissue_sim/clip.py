"""Ligation clips: latch around what lies between the jaws, squeeze it, hold, or get lost."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.tubes import Crossing, Tubes

CLIP_LENGTH_M = 0.0095  # leg length of a medium-large polymer clip, assumed
CLIP_WIDTH_M = 0.0022  # along the tube, assumed
LATCH_GAP_M = 0.0016  # legs' distance at their middle at which the lock snaps, assumed
SQUEEZES = (  # layer of a ring, springs' stiffness (N/m a pair), rest distance over tube radius
    ("inner", 15000.0, 0.002),
    ("outer", 5000.0, 0.30),
)
CLIP_FRICTION = 0.8  # toothed legs on tissue, assumed


@dataclass(frozen=True, kw_only=True)
class Clip:
    """One clip in the field.

    Attributes:
        number: in the order of closing, from 1.
        crossings: where it sits on each tube it caught; empty when it caught nothing.
        complete: for each crossing, whether the tube's whole width lies between the legs.
        on_sac: whether part of the gallbladder is caught too.
        links: rows of its squeezing springs.
        vertices: what it caught.
        lost: it no longer holds.
        T_world_clip: where it closed; its drawn place follows `vertices`.
    """

    number: int
    time_s: float
    crossings: tuple[Crossing, ...]
    complete: tuple[bool, ...]
    on_sac: bool
    links: tuple[int, ...]
    vertices: tuple[int, ...]
    lost: bool
    T_world_clip: Array

    def on(self, tube: str) -> Crossing | None:
        """Its place on a tube, if it is on it."""
        return next((c for c in self.crossings if c.tube == tube), None)


def latch(tubes: Tubes, T_world_tool: Array, *, number: int, time_s: float) -> Clip:
    """Close a clip where the applier's jaws are; its legs cover what they hold."""
    local = transform(inverse_pose(T_world_tool), tubes.tissue.positions(tubes.b).astype(float))
    crossings, complete, springs, caught = [], [], [], []
    for tube in tubes.organ.tubes:
        crossing = tubes.crossing(tube, T_world_tool, CLIP_LENGTH_M)
        if crossing is None:
            continue
        rings = tubes.below[tube][_rings_under(tubes, local, crossing)]
        inside = _between_legs(local[rings])
        crossings.append(crossing)
        complete.append(bool(inside.all()))
        for ring, held in zip(rings, inside, strict=True):
            springs += _squeeze(ring, held, local, tubes.radius_m(tube))
            caught += ring[held].tolist()
    tubes.tissue.host("covered")[tubes.b, caught] = 1
    links = _add(tubes, springs)
    return Clip(
        number=number,
        time_s=time_s,
        crossings=tuple(crossings),
        complete=tuple(complete),
        on_sac=tubes.sac_between(T_world_tool, CLIP_LENGTH_M, CLIP_WIDTH_M),
        links=links,
        vertices=tuple(caught),
        lost=not crossings,
        T_world_clip=T_world_tool.copy(),
    )


def grip_n(tubes: Tubes, clip: Clip) -> float:
    """How hard the legs press on the tissue: the tension of the squeezing springs, N."""
    tissue, b, rows = tubes.tissue, tubes.b, list(clip.links)
    x = tissue.positions(b)[tissue.host("link")[b, rows]].astype(float)
    stretch = np.linalg.norm(x[:, 1] - x[:, 0], axis=1) - tissue.host("link_rest")[b, rows]
    return float((tissue.host("link_stiffness")[b, rows] * np.maximum(stretch, 0.0)).sum())


def retention_n(tubes: Tubes, clip: Clip) -> float:
    """The pull both legs hold by friction; zero when the clip does not embrace a whole tube."""
    return 2 * CLIP_FRICTION * grip_n(tubes, clip) if clip.complete and all(clip.complete) else 0.0


def lose(tubes: Tubes, clip: Clip) -> Clip:
    """The clip comes off: its springs go, the tissue springs back."""
    tubes.tissue.host("link_stiffness")[tubes.b, list(clip.links)] = 0.0
    tubes.tissue.host("covered")[tubes.b, list(clip.vertices)] = 0
    tubes.tissue.rewire(tubes.b)
    return replace(clip, lost=True)


def closure(tubes: Tubes, clip: Clip, tube: str) -> float:
    """Smallest lumen under the clip over its area at rest; 1 when it is not on the tube."""
    crossing = clip.on(tube)
    if clip.lost or crossing is None:
        return 1.0
    return float(tubes.lumen_fraction(tube)[crossing.ring])


def _rings_under(tubes: Tubes, local: Array, crossing: Crossing) -> NDArray[np.int64]:
    """Rings within the clip's width, at least the nearest."""
    neck = tubes.organ.neck_ring[crossing.tube]
    centres = local[tubes.below[crossing.tube][: neck + 1, 0]]
    near = np.linalg.norm(centres - crossing.point_m, axis=1) < 3 * CLIP_WIDTH_M
    under = near & (np.abs(centres[:, 0]) <= CLIP_WIDTH_M / 2)
    under[crossing.ring] = True
    return np.flatnonzero(under)


def _between_legs(local: Array) -> NDArray[np.bool_]:
    return (local[..., 2] > -CLIP_LENGTH_M) & (local[..., 2] < 2.0e-4)


def _squeeze(
    ring: NDArray[np.int32], held: NDArray[np.bool_], local: Array, radius_m: float
) -> list[tuple[int, int, float, float]]:
    """Springs of one ring between its two flattened halves: vertices, rest (m), stiffness."""
    if not held.any():
        return []
    n = (len(ring) - 1) // 2
    middle = float(np.median(local[ring[held], 1]))
    layers = {"inner": slice(1, 1 + n), "outer": slice(1 + n, None)}
    springs = []
    for name, stiffness, rest in SQUEEZES:
        vertices = ring[layers[name]][held[layers[name]]]
        vertices = vertices[np.argsort(local[vertices, 2])]
        above = local[vertices, 1] > middle
        upper, lower = vertices[above], vertices[~above]
        for k in range(max(len(upper), len(lower)) if len(upper) and len(lower) else 0):
            i, j = (int(half[min(k, len(half) - 1)]) for half in (upper, lower))
            springs.append((i, j, rest * radius_m, stiffness))
    return springs


def _add(tubes: Tubes, springs: list[tuple[int, int, float, float]]) -> tuple[int, ...]:
    if not springs:
        return ()
    table = np.array(springs)
    rows = tubes.tissue.add_links(
        tubes.b,
        table[:, :2].astype(int),
        rest_m=table[:, 2],
        stiffness=table[:, 3],
        strength_n=1.0e9,
    )
    tubes.tissue.rewire(tubes.b)
    return tuple(int(r) for r in rows)
