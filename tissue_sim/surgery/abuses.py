"""Rough handling that tears nothing at once: crush, stretch, blunt force, stabs, and stray clips.

Nothing here acts: every quantity is read from the field, as in `injuries`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tissue_sim.field import Field
from tissue_sim.surgery.clip import CLIP_LENGTH_M, CLIP_WIDTH_M, Clip
from tissue_sim.surgery.grasp import LEFT_FINGERS, RIGHT_FINGERS, inward_n
from tissue_sim.surgery.injury import LimitReading
from tissue_sim.surgery.record import Record
from tissue_sim.thresholds import (
    BLUNT_MAX_N,
    CLIPS_LEFT_MAX,
    CRUSH_MAX_N,
    MAX_STRETCH,
    PIERCED_M,
)
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

FINGER_PLACES = (1.0, 0.6, 0.2)  # shares of a finger's length, from the jaws' hinge to the tip


def readings(field: Field, r: Record) -> Iterator[LimitReading]:
    """Yield every quantity of this file that can exceed its limit in any step.

    Args:
        field: after the step.
        r: its new record.
    """
    yield from crushed(field, r)
    if r.pull is None:  # the judge's own test pull stretches the tube between clip and clamp
        yield from stretched(field)
    yield LimitReading(event="blunt force", value=_blunt_n(field), limit=BLUNT_MAX_N)
    yield LimitReading(event="perforation of gallbladder", value=_stab_m(field), limit=PIERCED_M)
    lost = sum(clip.lost for clip in r.clips)
    yield LimitReading(event="clips left in the body", value=lost, limit=CLIPS_LEFT_MAX)


def crushed(field: Field, r: Record) -> Iterator[LimitReading]:
    """Yield the pinch on each tube between the two fingers of a tool, N.

    The applier crushes the tube under its clip, which is what clips are for: it counts only when it
    has no clip to close. Scissors cut what is between them.
    """
    empty = field.arms.mounted[RIGHT_ARM].name == "clip_applier" and not _closes_clip(field, r)
    arms = {LEFT_ARM: LEFT_FINGERS} | ({RIGHT_ARM: RIGHT_FINGERS} if empty else {})
    tools = field.arms.T_world_tool()
    touching = np.unique(field.tissue.host("contact_shape")[0])
    for tube in field.organ.tubes:
        pinches = [
            min(inward_n(field.tissue, field.tubes.vertices(tube), fingers, tools[arm]))
            for arm, fingers in arms.items()
            if np.isin(fingers, touching).all()
        ]
        pinch_n = max([0.0, *pinches])
        yield LimitReading(event=f"crush of {tube}", value=pinch_n, limit=CRUSH_MAX_N)


def stretched(field: Field) -> Iterator[LimitReading]:
    """Yield the elongation of each tube that is not severed, over its length at rest."""
    for tube in field.organ.tubes:
        if not len(field.tubes.severed_rings(tube)):
            longer = field.tubes.stretch(tube) - 1.0
            yield LimitReading(event=f"stretch of {tube}", value=longer, limit=MAX_STRETCH - 1.0)


def clipped_twice(before: Sequence[Clip], clip: Clip) -> Iterator[LimitReading]:
    """Yield the width, m, by which a new clip overlaps a clip that is on the same tube."""
    for old, crossing in ((c, x) for c in before if not c.lost for x in clip.crossings):
        other = old.on(crossing.tube)
        if other is not None:
            overlap_m = CLIP_WIDTH_M - abs(crossing.station_m - other.station_m)
            if overlap_m > 0.0:
                yield LimitReading(event="clip on clip", value=overlap_m, limit=0)


def _closes_clip(field: Field, r: Record) -> bool:
    """Tell whether the applier's jaws hold a clip, or have not opened since one latched in them."""
    if r.clip_loaded:
        return True
    T = field.arms.T_world_tool()[RIGHT_ARM]
    middle = T[:3, 3] - 0.5 * CLIP_LENGTH_M * T[:3, 2]
    return not r.jaws_opened and any(
        np.linalg.norm(field.clip_position_m(c) - middle) < CLIP_LENGTH_M
        for c in r.clips
        if not c.lost
    )


def _blunt_n(field: Field) -> float:
    """Return the force between the right instrument, as a whole, and the tissue, N."""
    return float(np.linalg.norm(field.tool_forces_n()[RIGHT_ARM]))


def _stab_m(field: Field) -> float:
    """Return how deep the deepest place of the right fingers is in the gallbladder, m."""
    near, far = (ends[list(RIGHT_FINGERS)].astype(float) for ends in field.tissue.tool_axes())
    return field.sac.depth_m(np.concatenate([near + s * (far - near) for s in FINGER_PLACES]))
