"""What does a control step do to the tissue? Clips latch, blades cut, walls tear, wounds leak."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tissue_sim.field import Field
from tissue_sim.frames import Array
from tissue_sim.surgery import abuses, injuries
from tissue_sim.surgery.clip import Clip, grip_n, latch
from tissue_sim.surgery.clip_bar import leave_jaws, pushes_n
from tissue_sim.surgery.clip_slip import Pull, apply_pull, update_after_cut, update_after_hole
from tissue_sim.surgery.cut import SHEAR_GAP_M, sever
from tissue_sim.surgery.grasp import RIGHT_FINGERS, follow_grasp
from tissue_sim.surgery.injury import InjuryMonitor
from tissue_sim.surgery.leak import hole_leak, leaks, root_leaks
from tissue_sim.surgery.loose_clip import fall, push_aside
from tissue_sim.surgery.record import Record
from tissue_sim.surgery.tear import Load, tear, worst_load
from tissue_sim.thresholds import PIERCED_M, SAC_MAX_STRETCH
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.instruments import BLADE_LENGTH_M, clip_of

JAWS_OPEN_RAD = 0.25  # assumed: opening of a tool that must precede its closing on tissue


def record_step(field: Field, step_s: float, beyond_rad: float, intended: str | None) -> Record:
    """Apply a control step's events to the tissue, and return the record after the step.

    Args:
        field: The field, whose tools and tissue have just moved.
        step_s: Duration of the step.
        beyond_rad: Excess of the command over the joints' limits, rad (insertion: m).
        intended: The intended structure; None for the structure nearest to the jaws.
    """
    r = field.record
    time_s = r.time_s + step_s
    monitor = InjuryMonitor(r.injuries, r.broken_limits, r.peaks)
    pushes = pushes_n(field.tubes, r.clips)
    r = _use_right_tool(field, time_s, intended, monitor)
    for clip, force_n in pushes:
        pull = Pull(number=clip.number, force_world_n=force_n, grip_n=grip_n(field.tubes, clip))
        r = _pull(field, r, pull, step_s, monitor)
    field.tissue.load_walls()
    loads = [worst_load(field.tubes, tube) for tube in field.organ.hollow]
    monitor.watch(injuries.wall_loads(field, loads), time_s)
    stab_m = abuses.stab_m(field)
    if stab_m > PIERCED_M:
        _pierce(field)
    r = _tear(field, r, loads, time_s)
    if any(clip.sac_rings for clip in r.clips):
        r = _with_clips(r, [update_after_hole(field.tubes, clip) for clip in r.clips])
    if any(clip.lost or clip.in_jaws for clip in r.clips):
        r = _with_clips(r, _clips_beside_tools(field, r.clips, step_s))
    if r.pull is not None:
        r = _pull(field, r, r.pull, step_s, monitor)
    r = _leak(field, r, step_s)
    T_world_tool = field.arms.T_world_tool()[LEFT_ARM]
    grasp = follow_grasp(r.grasp, field.tissue, field.organ, T_world_tool, time_s)
    monitor.watch(injuries.other_readings(field, r, grasp, beyond_rad), time_s)
    monitor.watch(abuses.readings(field, r, stab_m), time_s)
    return replace(
        r,
        time_s=time_s,
        grasp=grasp,
        injuries=tuple(monitor.events),
        broken_limits=frozenset(monitor.broken),
        peaks=tuple(monitor.peaks.values()),
    )


def _use_right_tool(
    field: Field, time_s: float, intended: str | None, monitor: InjuryMonitor
) -> Record:
    """Latch a clip or cut when the right jaws have just closed."""
    r, tool = field.record, field.arms.mounted[RIGHT_ARM]
    jaw_rad = field.arms.joints[RIGHT_ARM, 6]
    if tool.deed is None:
        return r
    apart = 2.0 * (tool.yaw_to_tip_m - 0.5 * tool.mouth_m[0]) * np.sin(0.5 * jaw_rad)
    if jaw_rad > JAWS_OPEN_RAD:
        return r if r.jaws_opened else replace(r, jaws_opened=True)
    if not r.jaws_opened or apart > (tool.clip.latch_gap_m if tool.clip else SHEAR_GAP_M):
        return r
    r = replace(r, jaws_opened=False)
    if tool.deed == "cut":
        return _cut(field, r, time_s, intended, monitor)
    return _clip(field, r, time_s, intended, monitor) if r.clip_loaded else r


def _clip(
    field: Field, r: Record, time_s: float, intended: str | None, monitor: InjuryMonitor
) -> Record:
    """Latch the loaded clip."""
    T, kind = field.arms.T_world_tool()[RIGHT_ARM], clip_of(field.arms.mounted[RIGHT_ARM])
    clip = latch(field.tubes, T, kind, number=len(r.clips) + 1, time_s=time_s)
    meant = intended if intended is not None else field.tubes.nearest(T, kind.length_m)
    for reading in (
        *injuries.wrongly_clipped(r.clips, clip, meant),
        *abuses.clipped_twice(r.clips, clip),
    ):
        monitor.add(reading, time_s)
    return replace(r, clips=(*r.clips, clip), clip_loaded=False)


def _cut(
    field: Field, r: Record, time_s: float, intended: str | None, monitor: InjuryMonitor
) -> Record:
    """Cut the tubes and the gallbladder's wall between the blades."""
    T = field.arms.T_world_tool()[RIGHT_ARM]
    meant = intended if intended is not None else field.tubes.nearest(T, BLADE_LENGTH_M)
    cuts = sever(field.tubes, T, time_s=time_s)
    opened_m2 = _slit_sac(field, T)
    for reading in injuries.wrongly_cut(cuts, meant, opened_m2):
        monitor.add(reading, time_s)
    r = replace(r, cuts=(*r.cuts, *cuts))
    return _part_clips(field, r) if cuts else r


def _slit_sac(field: Field, T_world_tool: Array) -> float | None:
    """Open the gallbladder's wall between the blades.

    Returns:
        The area opened, m^2; None when there was no wall between them.
    """
    slit = field.sac.under_blades(T_world_tool, BLADE_LENGTH_M)
    if not slit.size:
        return None
    before_m2 = field.sac.hole_m2()
    field.sac.open(slit)
    return field.sac.hole_m2() - before_m2


def _pierce(field: Field) -> None:
    """Open the gallbladder's wall where the right fingers have entered it."""
    near, far = (ends[list(RIGHT_FINGERS)].astype(float) for ends in field.tissue.tool_axes())
    inside = [field.sac.depth_m(tip[None]) > 0.0 for tip in far]
    holes = field.sac.pierced(far[inside], (2.0 * near - far)[inside])
    if holes.size:
        field.sac.open(holes)


def _tear(field: Field, r: Record, loads: Sequence[Load], time_s: float) -> Record:
    """Tear the walls that are loaded beyond their strength."""
    if field.sac.stretch() > SAC_MAX_STRETCH:
        field.sac.tear()
    torn = [tear(field.tubes, load, time_s=time_s) for load in loads if load.pull_n > load.holds_n]
    if not torn:
        return r
    r = replace(r, tears=(*r.tears, *(t for t in torn if t is not None)))
    return _part_clips(field, r)


def _with_clips(r: Record, clips: Sequence[Clip]) -> Record:
    """Return the record with these clips, itself if no clip has changed."""
    if all(clip is before for clip, before in zip(clips, r.clips, strict=True)):
        return r
    return replace(r, clips=tuple(clips))


def _clips_beside_tools(field: Field, clips: Sequence[Clip], step_s: float) -> list[Clip]:
    """Return the clips after instruments and gravity have moved them.

    A clip may leave the jaws, be pushed aside, or fall.
    """
    shapes = field.arms.contact_shapes()
    now = [leave_jaws(field.tubes, clip, shapes) for clip in clips]
    now = [push_aside(clip, shapes) if clip.lost else clip for clip in now]
    return [fall(clip, field.organ.bed, step_s) for clip in now]


def _part_clips(field: Field, r: Record) -> Record:
    """Leave severed tissue under a clip's legs with its own stump."""
    return replace(r, clips=tuple(update_after_cut(field.tubes, clip) for clip in r.clips))


def _pull(field: Field, r: Record, pull: Pull, step_s: float, monitor: InjuryMonitor) -> Record:
    """Move the pulled clip."""
    k = pull.number - 1
    before = r.clips[k]
    clip = apply_pull(field.tubes, before, pull, step_s)
    for reading in injuries.pulled_loose(before, clip):
        monitor.add(reading, r.time_s + step_s)
    if clip.lost:
        field.tissue.host("load")[0] = 0.0
        r = replace(r, pull=None)
    return replace(r, clips=(*r.clips[:k], clip, *r.clips[k + 1 :]))


def _leak(field: Field, r: Record, step_s: float) -> Record:
    """Find the current leaks, and add up the lost volume."""
    fullness = max(1.0 - r.drained_m3 / field.sac.contents_m3, 0.0)
    leaking = leaks(field.tubes, r.clips, r.openings, fullness=fullness)
    leaking += hole_leak(field.sac, fullness=fullness)
    leaking += root_leaks(field.tubes, r.clips, fullness=fullness)
    if not leaking and not r.leaks:
        return r
    return replace(
        r,
        leaks=leaking,
        leaked_m3=r.leaked_m3 + step_s * sum(x.rate_m3_s for x in leaking),
        drained_m3=r.drained_m3 + step_s * sum(x.rate_m3_s for x in leaking if x.drains_sac),
    )
