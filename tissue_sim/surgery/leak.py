"""Compute leaks of bile and blood from open stumps, and from holes in gallbladder and trunks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from tissue_sim.frames import Array
from tissue_sim.patient.at_risk import BRANCHES, COMMON_DUCT, HEPATIC_ARTERY
from tissue_sim.patient.material import WALL_THICKNESS_M
from tissue_sim.patient.sac import Sac
from tissue_sim.patient.tubes import Tubes
from tissue_sim.surgery.clip import Clip, closure
from tissue_sim.surgery.flow import BILE, BLOOD, FlowSegment, Fluid, outflow_m3_s
from tissue_sim.surgery.parting import Opening
from tissue_sim.thresholds import LUMEN_CLOSED

SIDES = ("body", "gallbladder")  # of a trunk: its two ways out of the field
HOLE = "hole"  # instead of a side
FLUIDS: dict[str, Fluid] = {
    "duct": BILE,
    "artery": BLOOD,
    "second artery": BLOOD,
    COMMON_DUCT: BILE,
    HEPATIC_ARTERY: BLOOD,
}
DRAIN = ("duct", "gallbladder")  # the gallbladder drains through this stump
BILE_PRESSURE_PA = 1.2e3  # assumed: in ducts and gallbladder at rest, 12 cm of water
ARTERIAL_PRESSURE_PA = 12.4e3  # textbook value: mean, 93 mmHg
BACK_PRESSURE_PA = 2.0e3  # assumed: from the gallbladder's small vessels
PRESSURE_PA = {
    ("duct", "body"): BILE_PRESSURE_PA,
    ("duct", "gallbladder"): BILE_PRESSURE_PA,
    ("artery", "body"): ARTERIAL_PRESSURE_PA,
    ("artery", "gallbladder"): BACK_PRESSURE_PA,
    ("second artery", "body"): ARTERIAL_PRESSURE_PA,
    ("second artery", "gallbladder"): BACK_PRESSURE_PA,
    (COMMON_DUCT, "body"): BILE_PRESSURE_PA,
    (COMMON_DUCT, "gallbladder"): BILE_PRESSURE_PA,
    (HEPATIC_ARTERY, "body"): ARTERIAL_PRESSURE_PA,
    (HEPATIC_ARTERY, "gallbladder"): BACK_PRESSURE_PA,
}


@dataclass(frozen=True, kw_only=True)
class Leak:
    """A leak and its rate (m^3/s).

    Attributes:
        structure: A tube, or "gallbladder".
        side: Side of a tube's opening from which the fluid comes. "hole" stands for the
            gallbladder, and for a trunk whose branch is torn off.
        ring: The severed ring of a tube; -1 for a hole.
    """

    structure: str
    side: str
    ring: int
    rate_m3_s: float

    @property
    def drains_sac(self) -> bool:
        """Return whether the lost fluid is the gallbladder's own bile."""
        return self.structure == "gallbladder" or (self.structure, self.side) == DRAIN


@dataclass(frozen=True, kw_only=True)
class Spill:
    """Liquid that came from one structure's openings at one place.

    Attributes:
        structure: As in `Leak`.
        place_m: (3,) place of the opening in the body at its anatomical place, world axes.
        volume_m3: All that has leaked there so far.
    """

    structure: str
    place_m: Array
    volume_m3: float


def leaks(
    tubes: Tubes, clips: Sequence[Clip], openings: Sequence[Opening], *, fullness: float = 1.0
) -> tuple[Leak, ...]:
    """Return the leaks of all stumps of tubes that were cut or torn.

    Of several openings in a tube only the outer two leak, one from each side.

    Args:
        tubes: The patient's tubes.
        clips: All clips, including lost ones.
        openings: All cuts and tears.
        fullness: Filling of the gallbladder, 0 to 1. Its pressure is assumed proportional to the
            filling.
    """
    found = []
    for tube in dict.fromkeys(o.tube for o in openings):
        ordered = sorted((o for o in openings if o.tube == tube), key=lambda o: o.station_m)
        for side, opening in zip(SIDES, (ordered[0], ordered[-1]), strict=True):
            pressure = PRESSURE_PA[tube, side] * (fullness if (tube, side) == DRAIN else 1.0)
            way = _way_out(tubes, clips, opening, side)
            if way:
                rate = outflow_m3_s(FLUIDS[tube], pressure, way)
                found.append(Leak(structure=tube, side=side, ring=opening.ring, rate_m3_s=rate))
    return tuple(found)


def hole_leak(sac: Sac, *, fullness: float = 1.0) -> tuple[Leak, ...]:
    """Return the gallbladder's leak through its holes, if it has any."""
    if not sac.open_patches().size:
        return ()
    way = FlowSegment(length_m=WALL_THICKNESS_M["gallbladder"], area_m2=sac.hole_m2())
    rate = outflow_m3_s(BILE, BILE_PRESSURE_PA * fullness, [way])
    return (Leak(structure="gallbladder", side=HOLE, ring=-1, rate_m3_s=rate),)


def root_leaks(tubes: Tubes, clips: Sequence[Clip], *, fullness: float = 1.0) -> tuple[Leak, ...]:
    """Return the leaks where a branch is torn off its trunk: of the trunk, and of the branch.

    The hole is as wide as the branch's lumen, and its open share is the torn share. No clip closes
    the hole. A clip on the branch closes the branch.
    """
    found = []
    for trunk, branch in BRANCHES.items():
        torn = tubes.torn_share(trunk)
        if torn == 0.0:
            continue
        mouth = FlowSegment(length_m=0.0, area_m2=torn * tubes.rest_lumen_m2(branch)[0])
        hole = replace(mouth, length_m=WALL_THICKNESS_M[trunk])
        rate = outflow_m3_s(FLUIDS[trunk], PRESSURE_PA[trunk, SIDES[0]], [hole])
        found.append(Leak(structure=trunk, side=HOLE, ring=-1, rate_m3_s=rate))
        side = SIDES[1]
        way = _way_along(tubes, clips, branch, 0, 0.0, side)
        if way:
            pressure = PRESSURE_PA[branch, side] * (fullness if (branch, side) == DRAIN else 1.0)
            rate = outflow_m3_s(FLUIDS[branch], pressure, (*way, mouth))
            found.append(Leak(structure=branch, side=side, ring=0, rate_m3_s=rate))
    return tuple(found)


def _way_out(
    tubes: Tubes, clips: Sequence[Clip], opening: Opening, side: str
) -> tuple[FlowSegment, ...]:
    """Return the flow path from the source on one side to an opening; empty if a clip closes it."""
    tube, ring = opening.tube, opening.ring
    mouth = tubes.open_share(tube, ring)
    way = _way_along(tubes, clips, tube, ring, opening.station_m, side)
    if mouth == 0.0 or not way:
        return ()
    return (*way, FlowSegment(length_m=0.0, area_m2=tubes.rest_lumen_m2(tube)[ring] * mouth))


def _way_along(
    tubes: Tubes, clips: Sequence[Clip], tube: str, ring: int, station_m: float, side: str
) -> tuple[FlowSegment, ...]:
    """Return the flow path along a tube up to a ring; empty if a clip closes it."""
    lumen = tubes.rest_lumen_m2(tube)[ring]
    length = station_m if side == SIDES[0] else tubes.length_m[tube] - station_m
    between = [
        (clip.kind.width_m, closure(tubes, clip, tube))
        for clip in clips
        if _stands_between(clip, tube, station_m, side)
    ]
    if min((share for _, share in between), default=1.0) <= LUMEN_CLOSED:
        return ()
    squeezed = [FlowSegment(length_m=w, area_m2=lumen * min(s, 1.0)) for w, s in between]
    return (FlowSegment(length_m=length, area_m2=lumen), *squeezed)


def _stands_between(clip: Clip, tube: str, station_m: float, side: str) -> bool:
    crossing = clip.on(tube)
    if clip.lost or crossing is None:
        return False
    return (crossing.station_m < station_m) == (side == SIDES[0])
