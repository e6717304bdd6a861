"""Which rough handling tears nothing at once? Crush, stretch, blunt force, stabs, stray clips.

Nothing here acts: every quantity is read from the field, as in `injuries`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tissue_sim.field import Field
from tissue_sim.mechanics.layout import N_SHAPES
from tissue_sim.patient.material import MATERIALS, SAC_MESH_WALL_M, WALL_THICKNESS_M
from tissue_sim.patient.mesher import Indices
from tissue_sim.surgery.clip import Clip
from tissue_sim.surgery.grasp import LEFT_FINGERS, RIGHT_FINGERS, inward_n
from tissue_sim.surgery.injury import LimitReading
from tissue_sim.surgery.record import Record
from tissue_sim.thresholds import (
    BLUNT_MAX_N,
    CLIPS_LEFT_MAX,
    CRUSH_MAX_N,
    CRUSHED_M2,
    MAX_STRETCH,
    PIERCED_M,
)
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

WALL_M = WALL_THICKNESS_M["gallbladder"]
WALL_PA = MATERIALS["gallbladder wall"].young_pa * SAC_MESH_WALL_M / WALL_M  # of the real wall
LEAST_GAP_M = 5e-5  # assumed: pads do not close further on tissue
FINGER_PLACES = (1.0, 0.5)  # shares of a finger's length, from the jaws' hinge to the tip


def readings(field: Field, r: Record, stab_m: float) -> Iterator[LimitReading]:
    """Yield every quantity of this file that can exceed its limit in any step.

    Args:
        field: the field after the step.
        r: the field's new record.
        stab_m: `stab_m(field)` in this step.
    """
    yield from crushed(field, r)
    yield crushed_wall(field, r)
    if r.pull is None:  # the judge's own test pull stretches the tube between clip and clamp
        yield from stretched(field, r)
    yield LimitReading(event="blunt force", value=_blunt_n(field), limit=BLUNT_MAX_N)
    yield LimitReading(event="perforation of gallbladder", value=stab_m, limit=PIERCED_M)
    lost = sum(clip.lost for clip in r.clips)
    yield LimitReading(event="clips left in the body", value=lost, limit=CLIPS_LEFT_MAX)


def crushed(field: Field, r: Record) -> Iterator[LimitReading]:
    """Yield the pinch on each tube between the two fingers of a tool, N.

    An applier that closes its clip crushes the tube on purpose. The applier's pinch therefore
    counts only without a clip, and after it has released its closed clip. Scissors cut the tissue
    between their blades, so their pinch does not count.
    """
    pinching = _pinching(field, r)
    for tube in field.organ.hollow:
        pinches = [_pinch_n(field, field.tubes.vertices(tube), *tool) for tool in pinching]
        value = max(pinches, default=0.0)
        yield LimitReading(event=f"crush of {tube}", value=value, limit=CRUSH_MAX_N)


def crushed_wall(field: Field, r: Record) -> LimitReading:
    """Return the pinch on a fold of the gallbladder's wall between the right fingers, N.

    The limit is the pressure that damages a tube. The meshed wall is softer across than the real
    one, so the pressure follows from the gap between the fingers. Scissors count, because wall that
    they cut is an injury in any case.
    """
    value = 0.0
    if not _closes_clip(field, r) and _wall_pinch_n(field) > 0.0:
        value = fold_pressure_pa(_gap_m(field)) * CRUSHED_M2
    return LimitReading(event="crush of gallbladder", value=value, limit=CRUSH_MAX_N)


def fold_pressure_pa(gap_m: float) -> float:
    """Return the pressure on two layers of the gallbladder's real wall in a gap.

    The law is linear in the logarithmic strain: E ln(2 t / gap), assumed.
    """
    return WALL_PA * max(float(np.log(2.0 * WALL_M / max(gap_m, LEAST_GAP_M))), 0.0)


def stretched(field: Field, r: Record) -> Iterator[LimitReading]:
    """Yield the elongation of each tube that is not severed, over its length at rest."""
    opened = {opening.tube for opening in r.openings}
    for tube, stretch in field.tubes.stretches().items():
        if tube not in opened or not len(field.tubes.severed_rings(tube)):
            event = f"stretch of {tube}"
            yield LimitReading(event=event, value=stretch - 1.0, limit=MAX_STRETCH - 1.0)


def clipped_twice(before: Sequence[Clip], clip: Clip) -> Iterator[LimitReading]:
    """Yield the largest width, m, by which a new clip overlaps a clip on the same tube, if any."""
    overlaps_m = [
        0.5 * (clip.kind.width_m + old.kind.width_m) - abs(x.station_m - other.station_m)
        for old in before
        for x in clip.crossings
        if not old.lost and (other := old.on(x.tube)) is not None
    ]
    if (overlap_m := max(overlaps_m, default=0.0)) > 0.0:
        yield LimitReading(event="clip on clip", value=overlap_m, limit=0)


def _pinching(field: Field, r: Record) -> list[tuple[int, tuple[int, int]]]:
    """Return arm and fingers of each tool that can crush and touches tubes with both fingers."""
    vertices = np.concatenate([field.tubes.vertices(tube) for tube in field.organ.hollow])
    touching = field.tissue.host("contact_shape")[0].take(vertices)
    touched = np.bincount(touching + 1, minlength=N_SHAPES + 1)[1:]
    empty = field.arms.mounted[RIGHT_ARM].deed == "clip" and not _closes_clip(field, r)
    tools = [(LEFT_ARM, LEFT_FINGERS)] + [(RIGHT_ARM, RIGHT_FINGERS)] * empty
    return [(arm, fingers) for arm, fingers in tools if touched[list(fingers)].all()]


def _closes_clip(field: Field, r: Record) -> bool:
    """Return whether the right tool is an applier that closes a clip, or still holds it."""
    holds = r.clip_loaded or any(clip.in_jaws and not clip.lost for clip in r.clips)
    return field.arms.mounted[RIGHT_ARM].deed == "clip" and holds


def _gap_m(field: Field) -> float:
    """Return the gap between the right fingers' pads, where the gallbladder's wall touches them."""
    tissue, tool = field.tissue, field.arms.mounted[RIGHT_ARM]
    sac = field.organ.sac_rings.ravel()
    held = sac[np.isin(tissue.host("contact_shape")[0, sac], RIGHT_FINGERS)]
    T_world_tool = field.arms.T_world_tool()[RIGHT_ARM]
    from_tip_m = (tissue.positions()[held].astype(float) - T_world_tool[:3, 3]) @ T_world_tool[
        :3, 2
    ]
    from_hinge_m = float(np.mean(tool.yaw_to_tip_m + from_tip_m))
    return 2.0 * from_hinge_m * float(np.sin(0.5 * field.arms.joints[RIGHT_ARM, 6]))


def _wall_pinch_n(field: Field) -> float:
    """Return the force of the right fingers on the gallbladder's wall between them, N."""
    return _pinch_n(field, field.organ.sac_rings.ravel(), RIGHT_ARM, RIGHT_FINGERS)


def _pinch_n(field: Field, vertices: Indices, arm: int, fingers: tuple[int, int]) -> float:
    """Return the smaller force of both fingers on vertices, inward; 0 if one does not press."""
    touching = field.tissue.host("contact_shape")[0, vertices]
    if not all((touching == finger).any() for finger in fingers):
        return 0.0
    T_world_tool = field.arms.T_world_tool()[arm]
    return max(min(inward_n(field.tissue, vertices, fingers, T_world_tool)), 0.0)


def _blunt_n(field: Field) -> float:
    """Return the total force between the right instrument and the tissue, N."""
    return float(np.linalg.norm(field.tool_forces_n()[RIGHT_ARM]))


def stab_m(field: Field) -> float:
    """Return the depth of the right fingers' deepest place in the gallbladder, m."""
    near, far = (ends[list(RIGHT_FINGERS)].astype(float) for ends in field.tissue.tool_axes())
    return field.sac.depth_m(np.concatenate([near + s * (far - near) for s in FINGER_PLACES]))
