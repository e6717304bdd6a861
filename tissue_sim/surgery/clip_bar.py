"""Treat a closed clip as a rigid bar, through which a touching object pushes the clipped tissue."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tissue_sim.frames import Array, transform
from tissue_sim.mechanics.bar_contact import BALLS, BAR_VERTICES, Bar
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import Clip, T_world_clip
from tissue_sim.tools.arms import ContactShapes
from tissue_sim.tools.clips import ClipKind

LEAST_EXTENT = 0.1  # assumed: of clipped tissue, over its largest; a smaller extent is no direction


def place_bars(tubes: Tubes, clips: Sequence[Clip]) -> None:
    """Let the tissue carry all clips that hold tissue."""
    bars = [bar_of(clip) for clip in clips if is_bar(clip)]
    tubes.tissue.place_bars(tubes.b, bars)


def pushes_n(tubes: Tubes, clips: Sequence[Clip]) -> list[tuple[Clip, Array]]:
    """Return the clips that instruments or other clips push now, and the forces (3,), N.

    The tube's own tension is not among these forces. The tension passes under the legs, on a stump
    as on a whole tube.

    Args:
        tubes: the tubes, after the step that began with these clips.
        clips: all clips that `place_bars` received.
    """
    force = tubes.tissue.host("bar_force")[tubes.b].astype(float)
    bars = [clip for clip in clips if is_bar(clip)][-len(force) :]
    return [(clip, f) for clip, f in zip(bars, force, strict=False) if f.any()]


def is_bar(clip: Clip) -> bool:
    """Return whether a clip holds enough vertices for the tissue to carry it."""
    return len(clip.vertices) > 1


def balls_m(kind: ClipKind) -> Array:
    """Return the centres of the balls (`BALLS`, 3) of a clip's bar, in the clip's frame."""
    reach_m = np.linspace(-1.0, 1.0, BALLS) * _reach_m(kind)
    return _middle_m(kind) + reach_m[:, None] * [0.0, 0.0, 1.0]


def _middle_m(kind: ClipKind) -> Array:
    return np.array([0.0, 0.0, -0.5 * kind.length_m])


def _reach_m(kind: ClipKind) -> float:
    """Return the distance from the clip's middle to the first and last ball's centre."""
    return 0.5 * kind.length_m - kind.bar_radius_m


def bar_of(clip: Clip) -> Bar:
    """Return a clip that holds tissue as a bar.

    The weights belong to the linear map from the held vertices' places in the clip to their current
    positions. The map is the best fit in least squares.
    """
    some = np.linspace(0, len(clip.vertices) - 1, min(len(clip.vertices), BAR_VERTICES)).astype(int)
    places_m = clip.places_m[some]
    centre_m = places_m.mean(axis=0)
    fit = np.linalg.pinv(places_m - centre_m, rcond=LEAST_EXTENT)  # (3, n)
    return Bar(
        vertices=np.array(clip.vertices)[some].tolist(),
        middle=1.0 / len(some) + (_middle_m(clip.kind) - centre_m) @ fit,
        axis=fit[2],
        reach_m=_reach_m(clip.kind),
        radius_m=clip.kind.bar_radius_m,
        in_jaws=clip.in_jaws,
    )


def leave_jaws(tubes: Tubes, clip: Clip, shapes: ContactShapes) -> Clip:
    """Return the clip, marked as out of the jaws if the jaws no longer touch it."""
    if not clip.in_jaws:
        return clip
    balls_world_m = transform(T_world_clip(tubes, clip), balls_m(clip.kind))
    depth_m, _ = depths(balls_world_m, clip.kind.bar_radius_m, shapes)
    if (depth_m[:, len(shapes.radius_m) // 2 :] > 0.0).any():
        return clip
    return replace(clip, in_jaws=False)


def depths(points_m: Array, radius_m: float, shapes: ContactShapes) -> tuple[Array, Array]:
    """Return the depths of balls of a clip (n, 3), of one radius, in instruments; the ways out.

    World frame. `mechanics.touch.touch` does the same for tissue, and stores sides.

    Returns:
        (n, 8) depth, m, negative outside; (n, 8, 3) unit normals.
    """
    along, across = shapes.b_world_m - shapes.a_world_m, shapes.w_world_m
    p = points_m[:, None] - shapes.a_world_m  # (n, 8, 3)
    t = np.clip((p * along).sum(-1) / ((along**2).sum(-1) + 1e-12), 0.0, 1.0)
    s = np.clip((p * across).sum(-1) / ((across**2).sum(-1) + 1e-12), -1.0, 1.0)
    off = p - t[..., None] * along - s[..., None] * across
    distance_m = np.linalg.norm(off, axis=-1)
    normal = off / (distance_m[..., None] + 1e-9)
    return shapes.radius_m + radius_m - distance_m, normal
