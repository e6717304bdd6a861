"""Remember what was spilt, and where: liquid stays in the field after its leak is closed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.patient.at_risk import BRANCHES
from tissue_sim.patient.sac import Sac
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.leak import HOLE, SIDES, Leak, Spill

APART_M = 0.005  # assumed: liquid from openings this far apart is remembered apart


def mouth_m(tubes: Tubes, sac: Sac, leak: Leak) -> Array:
    """Return the middle of the leaking opening (3,), world frame."""
    if leak.side == HOLE:
        trunk = leak.structure in BRANCHES
        return tubes.root_m(leak.structure) if trunk else sac.hole_centre()
    rings = tubes.below if leak.side == SIDES[0] else tubes.above
    centre = rings[leak.structure][leak.ring, 0]
    return tubes.tissue.positions(tubes.b)[centre].astype(float)


def spilt_more(
    before: tuple[Spill, ...], leaks: Sequence[Leak], places_m: Sequence[Array], step_s: float
) -> tuple[Spill, ...]:
    """Return all that was spilt, with what the leaks at these places added in a step."""
    spilt = list(before)
    for leak, place_m in zip(leaks, places_m, strict=True):
        if leak.rate_m3_s == 0.0:
            continue
        added_m3 = step_s * leak.rate_m3_s
        near = [k for k, spill in enumerate(spilt) if _is_there(spill, leak, place_m)]
        if near:
            old = spilt[near[0]]
            spilt[near[0]] = replace(old, volume_m3=old.volume_m3 + added_m3)
        else:
            spilt.append(Spill(structure=leak.structure, place_m=place_m, volume_m3=added_m3))
    return tuple(spilt)


def _is_there(spill: Spill, leak: Leak, place_m: Array) -> bool:
    near = np.linalg.norm(spill.place_m - place_m) < APART_M
    return spill.structure == leak.structure and bool(near)
