"""A clip that nothing holds falls freely, to the liver bed or to the floor of the field."""

from __future__ import annotations

from dataclasses import replace

from tissue_sim.clip import Clip
from tissue_sim.organ import LiverBed

FLOOR_M = -0.045  # height of the bowel below the field's centre, assumed
GRAVITY_M_S2 = 9.81


def fall(clip: Clip, bed: LiverBed, step_s: float) -> Clip:
    """The clip after a step. It falls upright and past the tissue, and stays where it lands."""
    if clip.fall_m_s is None:
        return clip
    speed = clip.fall_m_s + GRAVITY_M_S2 * step_s
    T = clip.T_world_clip.copy()
    T[2, 3] -= speed * step_s
    offset = T[:3, 3] - bed.point_m
    if offset @ bed.along > bed.edge_m and (height := offset @ bed.normal) < 0.0:
        T[:3, 3] -= height * bed.normal
    elif T[2, 3] <= FLOOR_M:
        T[2, 3] = FLOOR_M
    else:
        return replace(clip, T_world_clip=T, fall_m_s=speed)
    return replace(clip, T_world_clip=T, fall_m_s=None)
