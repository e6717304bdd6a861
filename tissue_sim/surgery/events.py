"""After each control step: what the tools did to the tissue, and what went wrong."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.surgery.clip import CLIP_LENGTH_M, LATCH_GAP_M, latch
from tissue_sim.surgery.cut import BLADE_LENGTH_M, SHEAR_GAP_M, sever
from tissue_sim.surgery.grasp import RIGHT_FINGERS, Grasp, follow_grasp, pinch_n
from tissue_sim.surgery.injury import InjuryMonitor, LimitReading
from tissue_sim.surgery.leak import hole_leak, leaks
from tissue_sim.surgery.loose_clip import fall
from tissue_sim.surgery.record import Record
from tissue_sim.surgery.slip import Pull, parted, under_pull
from tissue_sim.surgery.tear import Load, tear, worst_load
from tissue_sim.thresholds import (
    CLIP_MAX_SLIP_M,
    INSTRUMENT_CONTACT_MAX_N,
    JOINT_MARGIN_RAD,
    LEAK_MAX_M3,
    LIVER_MAX_N,
    PINCH_MAX_N,
    SAC_MAX_STRETCH,
    TORN_MAX,
    TRACTION_MAX_N,
)
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

if TYPE_CHECKING:
    from tissue_sim.world import World

JAWS_OPEN_RAD = 0.25  # a tool must have opened this far before it closes on something
CLOSING = {  # how far back from the tip a tool acts, and the jaws' distance there when it does
    "clip_applier": (CLIP_LENGTH_M, LATCH_GAP_M),
    "scissors": (BLADE_LENGTH_M, SHEAR_GAP_M),
}


def judge(world: World, joints: Array, intended: str | None) -> Record:
    """The record after a control step.

    Args:
        world: just stepped.
        joints: (2, 7) as commanded.
        intended: the structure meant; None for the one nearest to the jaws.
    """
    r = world.record
    time_s = r.time_s + world.config.control_step_s
    monitor = InjuryMonitor(r.injuries, r.broken_limits)
    r = _use_right_tool(world, time_s, intended, monitor)
    world.tissue.load_walls()
    loads = [worst_load(world.tubes, tube) for tube in world.organ.tubes]
    monitor.watch(_wall_readings(world, loads), time_s)
    r = _tear(world, r, loads, time_s)
    if any(c.fall_m_s is not None for c in r.clips):
        bed, step_s = world.organ.bed, world.config.control_step_s
        r = replace(r, clips=tuple(fall(c, bed, step_s) for c in r.clips))
    if r.pull is not None:
        r = _pull(world, r, r.pull, time_s, monitor)
    r = _leak(world, r)
    T_world_tool = world.arms.T_world_tool()[LEFT_ARM]
    grasp = follow_grasp(r.grasp, world.tissue, world.organ, T_world_tool, time_s)
    monitor.watch(_readings(world, joints, grasp, r), time_s)
    return replace(
        r,
        time_s=time_s,
        grasp=grasp,
        injuries=tuple(monitor.events),
        broken_limits=frozenset(monitor.broken),
    )


def _use_right_tool(
    world: World, time_s: float, intended: str | None, monitor: InjuryMonitor
) -> Record:
    """Latch a clip or cut when the right jaws have just closed."""
    r, tool = world.record, world.arms.mounted[RIGHT_ARM]
    jaw_rad = world.arms.joints[RIGHT_ARM, 6]
    reach, gap = CLOSING[tool.name]
    apart = 2.0 * (tool.yaw_to_tip_m - 0.5 * reach) * np.sin(0.5 * jaw_rad)
    if jaw_rad > JAWS_OPEN_RAD:
        return r if r.jaws_opened else replace(r, jaws_opened=True)
    if not r.jaws_opened or apart > gap:
        return r
    r = replace(r, jaws_opened=False)
    if tool.name == "scissors":
        return _cut(world, r, time_s, intended, monitor)
    return _clip(world, r, time_s, intended, monitor) if r.clip_loaded else r


def _clip(
    world: World, r: Record, time_s: float, intended: str | None, monitor: InjuryMonitor
) -> Record:
    T = world.arms.T_world_tool()[RIGHT_ARM]
    clip = latch(world.tubes, T, number=len(r.clips) + 1, time_s=time_s)
    meant = intended if intended is not None else world.tubes.nearest(T, CLIP_LENGTH_M)
    wrong = [c.tube for c in clip.crossings if c.tube != meant]
    for name in wrong + ["gallbladder"] * clip.on_sac:
        monitor.add(LimitReading(event=f"clip on {name}", value=1, limit=0), time_s)
    return replace(r, clips=(*r.clips, clip), clip_loaded=False)


def _cut(
    world: World, r: Record, time_s: float, intended: str | None, monitor: InjuryMonitor
) -> Record:
    T = world.arms.T_world_tool()[RIGHT_ARM]
    meant = intended if intended is not None else world.tubes.nearest(T, BLADE_LENGTH_M)
    cuts = sever(world.tubes, T, time_s=time_s)
    for name in [c.tube for c in cuts if c.tube != meant]:
        monitor.add(LimitReading(event=f"cut on {name}", value=1, limit=0), time_s)
    slit = world.sac.under_blades(T, BLADE_LENGTH_M)
    if slit.size:
        before_m2 = world.sac.hole_m2()
        world.sac.open(slit)
        opened_m2 = world.sac.hole_m2() - before_m2
        monitor.add(LimitReading(event="cut on gallbladder", value=opened_m2, limit=0), time_s)
    r = replace(r, cuts=(*r.cuts, *cuts))
    return _part_clips(world, r) if cuts else r


def _wall_readings(world: World, loads: Sequence[Load]) -> Iterator[LimitReading]:
    """How near each wall is to its ultimate strength: N for the tubes, stretch for the sac."""
    for load in loads:
        yield LimitReading(event=f"avulsion of {load.tube}", value=load.pull_n, limit=load.holds_n)
    yield LimitReading(
        event="tear of gallbladder", value=world.sac.stretch(), limit=SAC_MAX_STRETCH
    )


def _tear(world: World, r: Record, loads: Sequence[Load], time_s: float) -> Record:
    """Walls loaded beyond their strength give way."""
    if world.sac.stretch() > SAC_MAX_STRETCH:
        world.sac.tear()
    torn = [tear(world.tubes, load, time_s=time_s) for load in loads if load.pull_n > load.holds_n]
    if not torn:
        return r
    r = replace(r, tears=(*r.tears, *(t for t in torn if t is not None)))
    return _part_clips(world, r)


def _leak(world: World, r: Record) -> Record:
    """What leaks now, and how much that makes."""
    fullness = max(1.0 - r.drained_m3 / world.sac.contents_m3, 0.0)
    leaking = leaks(world.tubes, r.clips, r.openings, fullness=fullness)
    leaking += hole_leak(world.sac, fullness=fullness)
    if not leaking and not r.leaks:
        return r
    dt = world.config.control_step_s
    return replace(
        r,
        leaks=leaking,
        leaked_m3=r.leaked_m3 + dt * sum(x.rate_m3_s for x in leaking),
        drained_m3=r.drained_m3 + dt * sum(x.rate_m3_s for x in leaking if x.drains_sac),
    )


def _part_clips(world: World, r: Record) -> Record:
    """What was severed under a clip's legs stays with its own stump."""
    return replace(r, clips=tuple(parted(world.tubes, clip) for clip in r.clips))


def _pull(world: World, r: Record, pull: Pull, time_s: float, monitor: InjuryMonitor) -> Record:
    """What the pull under way does to its clip."""
    k = pull.number - 1
    before = r.clips[k]
    clip = under_pull(world.tubes, before, pull, world.config.control_step_s)
    if clip.slid_m > CLIP_MAX_SLIP_M >= before.slid_m:
        slip = LimitReading(event="clip slip", value=clip.slid_m, limit=CLIP_MAX_SLIP_M)
        monitor.add(slip, time_s)
    if clip.lost:
        monitor.add(LimitReading(event="clip off", value=1, limit=0), time_s)
        world.tissue.host("load")[0] = 0.0
        r = replace(r, pull=None)
    return replace(r, clips=(*r.clips[:k], clip, *r.clips[k + 1 :]))


def _readings(world: World, joints: Array, grasp: Grasp, r: Record) -> Iterator[LimitReading]:
    """Every other quantity that has a limit."""
    rigid = world.arms.contact_forces_n()
    beyond = float(np.abs(joints - world.target)[:, :6].max())
    for event, value, limit in (
        ("pinch", max(grasp.pinch_n, _right_pinch_n(world)), PINCH_MAX_N),
        ("traction", grasp.traction_n, TRACTION_MAX_N),
        ("liver force", rigid.on_liver_n, LIVER_MAX_N),
        ("liver force through gallbladder", world.bed_press_n() - r.bed_rest_n, LIVER_MAX_N),
        ("instrument contact", rigid.between_arms_n, INSTRUMENT_CONTACT_MAX_N),
        *_torn_attachments(world),
        ("leak", r.leaked_m3, LEAK_MAX_M3),
        ("joint limit", beyond, JOINT_MARGIN_RAD),
    ):
        yield LimitReading(event=event, value=value, limit=limit)


def _right_pinch_n(world: World) -> float:
    """Of the gallbladder, between the jaws of clip applier or scissors."""
    if not (world.tissue.host("contact_shape")[0] >= RIGHT_FINGERS[0]).any():
        return 0.0
    sac = world.organ.sac_rings.ravel()
    return pinch_n(world.tissue, sac, RIGHT_FINGERS, world.arms.T_world_tool()[RIGHT_ARM])


def _torn_attachments(world: World) -> Iterator[tuple[str, int, int]]:
    """How many springs have broken: of each tube in the sac, and of the sac on the liver."""
    ties, anchors = (world.tissue.host(f"{n}_stiffness")[0] == 0.0 for n in ("tie", "anchor"))
    for tube, rows in world.tubes.tie_rows.items():
        yield f"tear of {tube} from gallbladder", int(ties[rows].sum()), TORN_MAX
    yield "detachment from liver bed", int(anchors.sum()), TORN_MAX
