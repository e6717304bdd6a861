"""Model ligation clips, which latch around the tissue between the jaws, squeeze, hold or detach.

A clip's squeeze is springs between the two halves of each ring under its legs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array, inverse_pose, rigid_fit, transform
from tissue_sim.patient.organ import Organ
from tissue_sim.patient.tubes import MEETING_HALF_GAP_M, TIP_EDGE_M, Crossing, Tubes
from tissue_sim.surgery.wall_squeeze import (
    Spring,
    rings_of,
    wall_spacing_m,
    wall_springs,
    wall_under,
)
from tissue_sim.thresholds import CUFF_MIN_M
from tissue_sim.tools.clips import ClipKind

SEAT_SAMPLES = np.linspace(-0.5, 0.5, 9)  # sample places across the flattened tube


@dataclass(frozen=True, kw_only=True)
class Clip:
    """One clip in the field.

    Attributes:
        number: Order of closing or dropping, from 1.
        kind: Kind of the clip.
        crossings: Current or last place of the clip on each caught tube; empty if it caught none.
        complete: For each crossing, whether the tube's whole width lies between the legs.
        on_sac: Whether the clip also caught part of the gallbladder.
        sac_rings: The gallbladder's rings of which the legs squeeze a part.
        rings: For each crossing, the tube's rings under the legs.
        links: Rows of the clip's squeezing springs.
        vertices: The vertices that the clip holds.
        places_m: (n, 3) place of each of `vertices` in the clip's own frame.
        lost: Whether the clip holds nothing: it detached, closed on nothing or was dropped.
        slid_m: Distance by which the clip has been pulled along its tube.
        fall_m_s: Fall speed of the clip; None while it is held or lies still.
        T_world_clip: (4, 4) pose at which the clip closed; for a lost clip, its current pose.
        in_jaws: Whether the jaws that closed or dropped the clip still touch it; such jaws do not
            push it.
    """

    number: int
    kind: ClipKind
    time_s: float
    T_world_clip: Array
    crossings: tuple[Crossing, ...] = ()
    complete: tuple[bool, ...] = ()
    on_sac: bool = False
    sac_rings: tuple[int, ...] = ()
    rings: tuple[tuple[int, ...], ...] = ()
    links: tuple[int, ...] = ()
    vertices: tuple[int, ...] = ()
    places_m: Array = field(default_factory=lambda: np.zeros((0, 3)))
    lost: bool = False
    slid_m: float = 0.0
    fall_m_s: float | None = None
    in_jaws: bool = True

    @property
    def dropped(self) -> bool:
        """Return whether the clip was never on a tube.

        Such a clip closed on nothing, or fell from the applier.
        """
        return self.lost and not self.crossings

    @property
    def detached(self) -> bool:
        """Return whether the clip was on a tube and no longer is."""
        return self.lost and bool(self.crossings)

    def on(self, tube: str) -> Crossing | None:
        """Return the clip's crossing with a tube, or None."""
        return next((c for c in self.crossings if c.tube == tube), None)


def latch(tubes: Tubes, T_world_tool: Array, kind: ClipKind, *, number: int, time_s: float) -> Clip:
    """Close a clip at the applier's jaws; its legs cover the tissue between them."""
    local = transform(inverse_pose(T_world_tool), tubes.tissue.positions(tubes.b).astype(float))
    wall = wall_between(tubes.organ, local, kind)
    found = [tubes.crossing(tube, T_world_tool, kind.length_m) for tube in tubes.organ.hollow]
    crossings = tuple(c for c in found if c is not None)
    if not crossings:
        lost = dropped_clip(T_world_tool, kind, number=number, time_s=time_s)
        return replace(lost, on_sac=bool(wall.any()))
    complete, under, springs, caught = [], [], list[Spring](), list[int]()
    for crossing in crossings:
        side = tubes.side(crossing.tube, crossing.station_m)
        rings = _rings_under(tubes, local[side[:, 0]], crossing, kind.width_m)
        inside = _between_legs(local[side[rings]], kind.length_m)
        complete.append(bool(inside.all()))
        under.append(tuple(rings.tolist()))
        for ring, held in zip(side[rings], inside, strict=True):
            springs += springs_across(ring, held, local, tubes.radius_m(crossing.tube))
            caught += ring[held].tolist()
    on_wall = wall_springs(tubes.organ, local, wall, SQUEEZES)
    springs += on_wall
    caught += tubes.organ.sac_rings[wall].tolist()
    return Clip(
        number=number,
        kind=kind,
        time_s=time_s,
        crossings=crossings,
        complete=tuple(complete),
        on_sac=bool(wall.any()),
        sac_rings=rings_of(tubes.organ, on_wall),
        rings=tuple(under),
        links=squeeze(tubes, springs, caught),
        vertices=tuple(caught),
        places_m=local[caught],
        T_world_clip=T_world_tool.copy(),
    )


def wall_between(organ: Organ, local: Array, kind: ClipKind) -> NDArray[np.bool_]:
    """Return which vertices of the gallbladder, as in `sac_rings`, a clip's legs hold.

    Args:
        organ: The organ.
        local: (n_vertex, 3) positions in the clip's frame, m.
        kind: Kind of the clip.
    """
    between = _between_legs(local, kind.length_m) & (np.abs(local[:, 1]) < MEETING_HALF_GAP_M)
    return wall_under(organ, local, between, kind.width_m)


def dropped_clip(T_world_clip: Array, kind: ClipKind, *, number: int, time_s: float) -> Clip:
    """Return a clip that holds nothing and begins to fall."""
    return Clip(
        number=number,
        kind=kind,
        time_s=time_s,
        lost=True,
        fall_m_s=0.0,
        T_world_clip=T_world_clip.copy(),
    )


def T_world_clip(tubes: Tubes, clip: Clip) -> Array:
    """Return the current (4, 4) pose of a clip, which moves rigidly with its tissue."""
    if not clip.vertices:
        return clip.T_world_clip
    held = tubes.tissue.positions(tubes.b)[list(clip.vertices)].astype(float)
    return rigid_fit(clip.places_m, held)


def detach(tubes: Tubes, clip: Clip) -> Clip:
    """Detach the clip: remove its springs, let the tissue recover, and let the clip fall."""
    release(tubes, clip.links, clip.vertices)
    return replace(
        clip,
        lost=True,
        sac_rings=(),
        links=(),
        vertices=(),
        places_m=np.zeros((0, 3)),
        fall_m_s=0.0,
        T_world_clip=T_world_clip(tubes, clip),
    )


def closure(tubes: Tubes, clip: Clip, tube: str) -> float:
    """Return the lumen's area under the clip over its area at rest; 1 for a clip elsewhere."""
    crossing = clip.on(tube)
    if clip.lost or crossing is None:
        return 1.0
    return tubes.lumen_fraction_at(tube, crossing.ring, crossing.station_m)


def grip_n(tubes: Tubes, clip: Clip) -> float:
    """Return the force of the tissue on either leg, N.

    The springs represent whole rings of the mesh. Their tension over the length of tube that those
    rings represent is a line load, which acts over the clip's width. On the gallbladder's neck, the
    part of the width beyond the tube's end carries the wall's line load.
    """
    if not clip.links:
        return 0.0
    rings_m = sum(
        len(rings) * tubes.ring_spacing_m(c.tube)
        for c, rings in zip(clip.crossings, clip.rings, strict=True)
    ) / len(clip.crossings)
    if not clip.sac_rings:
        return tension_n(tubes, clip.links) * clip.kind.width_m / rings_m
    on_wall = np.isin(tubes.tissue.host("link")[tubes.b, clip.links, 0], tubes.organ.sac_rings)
    links, width_m = np.array(clip.links), clip.kind.width_m
    on_tube_m = min(_width_on_m(tubes, crossing, width_m) for crossing in clip.crossings)
    tube_n_m = tension_n(tubes, links[~on_wall]) / rings_m
    wall_n_m = tension_n(tubes, links[on_wall]) / wall_spacing_m(tubes.organ, clip.sac_rings)
    return tube_n_m * on_tube_m + wall_n_m * (width_m - on_tube_m)


def _width_on_m(tubes: Tubes, crossing: Crossing, width_m: float) -> float:
    """Return how much of a clip's width lies on its tube, below the gallbladder."""
    to_neck_m = tubes.length_m[crossing.tube] - crossing.station_m
    return float(np.clip(to_neck_m + 0.5 * width_m, 0.0, width_m))


def holding_forces_n(tubes: Tubes, clip: Clip, grip: float) -> tuple[float, float]:
    """Return the largest pulls that a clip holds along its tube and across it, N.

    Along the tube, both legs rub. The force is 2 mu N s cos(tilt), with grip N and seat s. It is at
    most what bends or slides off a clip of this kind. The pull-off force grows with the clip's
    seated area (Schenk et al., "Pull-off characteristics of double-shanked compared to
    single-shanked ligation clips", 2016). Ribs resist the part of the pull normal to the legs.

    Across the tube, the lock holds, unless the clip tips over the edge of its seat. The pull acts
    at the clip's middle, (1 - s) w / 2 from the middle of the seat. The seat's load N s can move by
    s w / 2 to balance the pull. A clip that does not enclose its whole tube slips off sideways and
    holds nothing.
    """
    if clip.lost or not all(clip.complete):
        return 0.0, 0.0
    seat = min(_seat(tubes, crossing, clip.kind.width_m) for crossing in clip.crossings)
    tilt = max(crossing.tilt_rad for crossing in clip.crossings)
    along = min(2.0 * clip.kind.friction * grip * seat * np.cos(tilt), clip.kind.slides_n)
    tips = grip * seat**2 / (1.0 - seat) if seat < 1.0 else np.inf
    return float(along), float(min(tips, clip.kind.lock_strength_n))


def _seat(tubes: Tubes, crossing: Crossing, width_m: float) -> float:
    """Return the share of the clip's area on the flattened tube that presses on firm tissue.

    Tissue nearer to a free end than the least cuff yields, because a load decays over about a
    tube's radius from a free end (Saint-Venant). The leading corner of a tilted clip is nearer to
    the end than the clip's middle.
    """
    flat_m = np.pi * tubes.radius_m(crossing.tube) * SEAT_SAMPLES
    lead_m = flat_m * np.tan(min(crossing.tilt_rad, np.deg2rad(80.0)))
    shares = [
        np.clip(0.5 + (cuff - CUFF_MIN_M - lead_m) / width_m, 0.0, 1.0).mean()
        for cuff in np.abs(tubes.free_ends_m(crossing.tube) - crossing.station_m)
    ]
    return float(min(shares, default=1.0))


def _rings_under(
    tubes: Tubes, centres: Array, crossing: Crossing, width_m: float
) -> NDArray[np.int64]:
    """Return the rings of this stump within the clip's width, at least the nearest one.

    Args:
        centres: (n_ring, 3) in the clip's frame, m.
    """
    first, last = tubes.stump(crossing.tube, crossing.station_m)
    near = np.linalg.norm(centres - crossing.point_m, axis=1) < 3 * width_m
    under = near & (np.abs(centres[:, 0]) <= width_m / 2)
    under[:first] = under[last + 1 :] = False
    under[crossing.ring] = True
    return np.flatnonzero(under)


def _between_legs(local: Array, length_m: float) -> NDArray[np.bool_]:
    return (local[..., 2] > -length_m) & (local[..., 2] < TIP_EDGE_M)


# The squeeze: the soft filling of a crushed lumen folds over. A few of its elements (2 kPa,
# assumed) are inverted while the clip is closed, and recover when it detaches. The walls are never
# inverted.

# Layer of a ring, stiffness of a spring (N/m), rest distance over the thickness of both walls: on a
# tube, its radius. Assumed: so stiff that the lumen closes
# (`tests/tissue_sim/verification/clip_closure.py`), the walls pressed flat.
SQUEEZES = (
    ("inner", 15000.0, 0.002),
    ("outer", 5000.0, 0.30),
)
UNBREAKABLE_N = 1.0e9  # no pull comes near it: a clip gives way by its lock and by friction


def springs_across(
    ring: NDArray[np.int32], held: NDArray[np.bool_], local: Array, radius_m: float
) -> list[Spring]:
    """Return the springs of one ring, between its upper and lower half.

    Args:
        ring: (1 + 2 n,) vertices: centre, inner, outer.
        held: whether each vertex lies between the legs.
        local: (n_vertex, 3) positions in the clip's frame, m.
        radius_m: radius of the tube.
    """
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


def squeeze(tubes: Tubes, springs: list[Spring], vertices: list[int]) -> tuple[int, ...]:
    """Cover vertices with the legs and press them together with springs; return their rows."""
    tubes.tissue.host("covered")[tubes.b, vertices] += 1
    table = np.array(springs).reshape(-1, 4)
    rows = tubes.tissue.add_links(
        tubes.b,
        table[:, :2].astype(int),
        rest_m=table[:, 2],
        stiffness=table[:, 3],
        strength_n=UNBREAKABLE_N,
    )
    tubes.tissue.rewire(tubes.b)
    return tuple(int(r) for r in rows)


def springs_in(tubes: Tubes, rows: tuple[int, ...]) -> list[Spring]:
    """Return the springs in these rows."""
    host, at = tubes.tissue.host, (tubes.b, list(rows))
    columns = (host("link")[at].tolist(), host("link_rest")[at], host("link_stiffness")[at])
    return [(i, j, float(L), float(k)) for (i, j), L, k in zip(*columns, strict=True)]


def release(tubes: Tubes, rows: tuple[int, ...], vertices: tuple[int, ...]) -> None:
    """Undo `squeeze`; vertices that another clip also covers stay covered."""
    tubes.tissue.host("link_stiffness")[tubes.b, list(rows)] = 0.0
    tubes.tissue.host("covered")[tubes.b, list(vertices)] -= 1
    tubes.tissue.rewire(tubes.b)


def tension_n(tubes: Tubes, rows: Sequence[int] | NDArray[np.integer]) -> float:
    """Return the sum of the springs' tensions, N."""
    host, at = tubes.tissue.host, (tubes.b, list(rows))
    x = tubes.tissue.positions(tubes.b)[host("link")[at]].astype(float)
    stretch = np.linalg.norm(x[:, 1] - x[:, 0], axis=1) - host("link_rest")[at]
    return float((host("link_stiffness")[at] * np.maximum(stretch, 0.0)).sum())
