"""A clip that nothing holds falls freely, onto the liver bed or the peritoneum behind the tubes."""

from __future__ import annotations

from dataclasses import replace

from tissue_sim.patient.axes import AWAY
from tissue_sim.patient.organ import LiverBed
from tissue_sim.surgery.clip import Clip

PERITONEUM_AWAY_M = 0.005  # assumed: how far behind the field it lies, where it is nearest
GRAVITY_M_S2 = 9.81


def fall(clip: Clip, bed: LiverBed, step_s: float) -> Clip:
    """Return the clip after a step.

    It keeps its orientation, falls past the tissue, and stays where it lands.
    """
    if clip.fall_m_s is None:
        return clip
    speed = clip.fall_m_s + GRAVITY_M_S2 * step_s
    T = clip.T_world_clip.copy()
    T[2, 3] -= speed * step_s
    tip = T[:3, 3]
    above_bed = tip - bed.point_m
    if above_bed @ bed.along > bed.edge_m and (height := above_bed @ bed.normal) < 0.0:
        T[:3, 3] -= height * bed.normal
    elif (inside := tip @ AWAY - PERITONEUM_AWAY_M) > 0.0:
        T[:3, 3] -= inside * AWAY
    else:
        return replace(clip, T_world_clip=T, fall_m_s=speed)
    return replace(clip, T_world_clip=T, fall_m_s=None)
