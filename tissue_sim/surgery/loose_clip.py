"""Let a loose clip fall freely, onto the liver bed or the peritoneum behind the tubes.

A clip that lies there moves with the body, as in breathing. Instruments push the clip aside. It
weighs a twentieth of a gram, so its force on them is left out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tissue_sim.frames import AWAY, Array, transform
from tissue_sim.patient.supports import LiverBed
from tissue_sim.surgery.clip import Clip
from tissue_sim.surgery.clip_bar import balls_m, depths
from tissue_sim.tools.arms import ContactShapes

PERITONEUM_AWAY_M = 0.005  # assumed: least distance of the peritoneum behind the field
GRAVITY_M_S2 = 9.81
PUSHES = 3  # out of one instrument, then out of another


def fall(clip: Clip, bed: LiverBed, offset_m: Array, moved_m: Array, step_s: float) -> Clip:
    """Return the clip after a step.

    The clip keeps its orientation, falls past the tissue, and stays where it lands in the body.

    Args:
        clip: Any clip; only a lost clip moves.
        bed: The liver bed, at its anatomical place.
        offset_m: Offset (3,) of the body from that place.
        moved_m: Motion (3,) of the body in the step.
        step_s: Duration of the step.
    """
    if not clip.lost:
        return clip
    T = clip.T_world_clip.copy()
    if clip.fall_m_s is None:
        T[:3, 3] += moved_m
        return replace(clip, T_world_clip=T) if moved_m.any() else clip
    speed = clip.fall_m_s + GRAVITY_M_S2 * step_s
    T[2, 3] -= speed * step_s
    tip = T[:3, 3] - offset_m
    above_bed = tip - bed.point_m
    if above_bed @ bed.along > bed.edge_m and (height := above_bed @ bed.normal) < 0.0:
        T[:3, 3] -= height * bed.normal
    elif (inside := tip @ AWAY - PERITONEUM_AWAY_M) > 0.0:
        T[:3, 3] -= inside * AWAY
    else:
        return replace(clip, T_world_clip=T, fall_m_s=speed)
    return replace(clip, T_world_clip=T, fall_m_s=None)


def push_aside(clip: Clip, shapes: ContactShapes) -> Clip:
    """Return a lost clip outside of the instruments; a pushed clip falls again."""
    n_shape = len(shapes.radius_m) // 2 if clip.in_jaws else len(shapes.radius_m)
    T, radius_m = clip.T_world_clip.copy(), clip.kind.bar_radius_m
    for _ in range(PUSHES):
        depth_m, normal = depths(transform(T, balls_m(clip.kind)), radius_m, shapes)
        ball = int(np.argmax(depth_m[:, :n_shape].max(axis=1)))
        touched = np.flatnonzero(depth_m[ball, :n_shape] > 0.0)
        if not len(touched):
            break
        thick_m = 2.0 * (shapes.radius_m[touched] + radius_m)
        T[:3, 3] += _way_out(depth_m[ball, touched], normal[ball, touched], thick_m)
    if (clip.T_world_clip == T).all():
        return clip
    return replace(clip, T_world_clip=T, fall_m_s=0.0)


def _way_out(depth_m: Array, normal: Array, thick_m: Array) -> Array:
    """Return the way (3,) of a ball out of all shapes: out of closed jaws, not between them.

    The way leads out of the shape with the least penetration, and through the others if necessary.
    """
    out = normal[np.argmin(depth_m)]
    return np.where(normal @ out > 0.0, depth_m, thick_m - depth_m).max() * out
