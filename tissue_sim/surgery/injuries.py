"""What has gone wrong? The file reads every quantity that has a limit, and changes nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tissue_sim.field import Field
from tissue_sim.patient.at_risk import BRANCHES
from tissue_sim.surgery.clip import Clip
from tissue_sim.surgery.cut import Cut
from tissue_sim.surgery.grasp import RIGHT_FINGERS, Grasp, pinch_n
from tissue_sim.surgery.injury import LimitReading
from tissue_sim.surgery.record import Record
from tissue_sim.surgery.tear import Load
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
from tissue_sim.tools.arms import RIGHT_ARM


def wrongly_clipped(before: Sequence[Clip], clip: Clip, meant: str) -> Iterator[LimitReading]:
    """Yield each structure under a new clip that is not the intended structure.

    A clip above another one on the intended tube leaves with the gallbladder, and may hold its
    wall; any other clip may not.
    """
    wrong = [c.tube for c in clip.crossings if c.tube != meant]
    own = clip.on(meant)
    below = [x for old in before if not old.lost and (x := old.on(meant)) is not None]
    leaves = own is not None and any(x.station_m < own.station_m for x in below)
    for name in wrong + ["gallbladder"] * (clip.on_sac and not leaves):
        yield LimitReading(event=f"clip on {name}", value=1, limit=0)


def wrongly_cut(cuts: Sequence[Cut], meant: str, opened_m2: float | None) -> Iterator[LimitReading]:
    """Yield each cut structure that is not the intended structure.

    Args:
        cuts: tubes that the blades cut.
        meant: the tube to be cut.
        opened_m2: area of the gallbladder's wall that the blades opened; None if they missed the
            wall.
    """
    for name in [c.tube for c in cuts if c.tube != meant]:
        yield LimitReading(event=f"cut on {name}", value=1, limit=0)
    if opened_m2 is not None:
        yield LimitReading(event="cut on gallbladder", value=opened_m2, limit=0)


def pulled_loose(before: Clip, clip: Clip) -> Iterator[LimitReading]:
    """Yield the test pull's effect on a clip in this step: too much slip, or detachment."""
    if clip.slid_m > CLIP_MAX_SLIP_M >= before.slid_m:
        yield LimitReading(event="clip slip", value=clip.slid_m, limit=CLIP_MAX_SLIP_M)
    if clip.lost:
        yield LimitReading(event="clip off", value=1, limit=0)


def wall_loads(field: Field, loads: Sequence[Load]) -> Iterator[LimitReading]:
    """Yield the load on each wall: N for the tubes, elongation for the gallbladder."""
    for load in loads:
        yield LimitReading(event=f"avulsion of {load.tube}", value=load.pull_n, limit=load.holds_n)
    longer = field.sac.stretch() - 1.0
    yield LimitReading(event="tear of gallbladder", value=longer, limit=SAC_MAX_STRETCH - 1.0)


def other_readings(
    field: Field, r: Record, grasp: Grasp, beyond_rad: float
) -> Iterator[LimitReading]:
    """Yield every other quantity that has a limit.

    Args:
        field: The field after the step.
        r: The field's new record, except for the grasp.
        grasp: The grasper's current hold on the gallbladder.
        beyond_rad: Excess of the command over the joints' limits, rad (insertion: m).
    """
    rigid = field.arms.contact_forces_n()
    for event, value, limit in (
        ("pinch", max(grasp.pinch_n, _right_pinch_n(field)), PINCH_MAX_N),
        ("traction", grasp.traction_n, TRACTION_MAX_N),
        ("liver force", rigid.on_liver_n, LIVER_MAX_N),
        ("liver force through gallbladder", field.bed_press_n() - r.bed_rest_n, LIVER_MAX_N),
        ("instrument contact", rigid.between_arms_n, INSTRUMENT_CONTACT_MAX_N),
        *_torn_attachments(field),
        ("leak", r.leaked_m3, LEAK_MAX_M3),
        ("joint limit", beyond_rad, JOINT_MARGIN_RAD),
    ):
        yield LimitReading(event=event, value=value, limit=limit)


def _right_pinch_n(field: Field) -> float:
    """Return the pinch on the gallbladder between the jaws of clip applier or scissors, N."""
    if not (field.tissue.host("contact_shape")[0] >= RIGHT_FINGERS[0]).any():
        return 0.0
    sac = field.organ.sac_rings.ravel()
    return pinch_n(field.tissue, sac, RIGHT_FINGERS, field.arms.T_world_tool()[RIGHT_ARM])


def _torn_attachments(field: Field) -> Iterator[tuple[str, int, int]]:
    """Count the broken springs: of tubes in sac and trunks, of the sac on the liver, of trunks."""
    ties, anchors = (field.tissue.host(f"{n}_stiffness")[0] == 0.0 for n in ("tie", "anchor"))
    for tube, rows in field.tubes.tie_rows.items():
        yield f"tear of {tube} from gallbladder", int(ties[rows].sum()), TORN_MAX
    for trunk, rows in field.tubes.root_rows.items():
        yield f"tear of {BRANCHES[trunk]} from {trunk}", int(ties[rows].sum()), TORN_MAX
    n_bed = len(field.organ.bed_vertices)
    yield "detachment from liver bed", int(anchors[:n_bed].sum()), TORN_MAX
    yield "tear of the ligament", int(anchors[n_bed:].sum()), TORN_MAX
