"""Define the exchangeable instruments of a PSM: sizes of wrist, jaws and clips, contact surfaces.

The numbers come from the tool table of the da Vinci research kit unless marked "assumed".
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import Literal

import numpy as np

from tissue_sim.frames import Array
from tissue_sim.tools.clips import CLIPS, MEDIUM_LARGE_POLYMER, MEDIUM_TITANIUM, ClipKind, kind_for

SHAFT_RADIUS_M = 0.004
SHAFT_LENGTH_M = 0.40  # assumed: longer than the way from a port into the field
WRIST_RADIUS_M = 0.0035  # assumed: the clevis is slimmer than the shaft
SHAFT_PATCH_LENGTH_M = 0.080

PATCH_LINKS = ("shaft", "wrist", "finger_plus", "finger_minus")

BLADE_LENGTH_M = 0.011  # assumed: curved scissors
BLADE_WIDTH_M = 0.0010  # assumed: thickness of the closed blades
GRASPER, CLIP_APPLIER, SCISSORS = "grasper", "clip_applier", "scissors"
SLIM_CLIP_APPLIER = "slim_clip_applier"


@dataclass(frozen=True, kw_only=True)
class Instrument:
    """One tool. `jaw` is the total opening angle: each finger opens by half of this angle.

    A finger pad extends from `finger_start_m` to `yaw_to_tip_m`, both measured from the yaw axis
    along the finger. Its rounded edge (radius: the half thickness) adds to the half width.

    `deed` is what closing jaws do to tissue between them for good; None if they only press. They
    do it over `mouth_m`. `clip` is the kind of clip that an applier places, and `blades_m` are
    length and width of the closed blades of scissors.
    """

    name: str
    pitch_to_yaw_m: float
    yaw_to_tip_m: float
    wrist_pitch_limit_rad: float
    wrist_yaw_limit_rad: float
    jaw_range_rad: tuple[float, float]
    finger_half_width_m: float
    finger_half_thickness_m: float
    finger_start_m: float
    jaw_torque_nm: float  # limits the pinch: force at distance r from the yaw axis <= torque / r
    arm: Literal["left", "right"] = "right"
    deed: Literal["clip", "cut"] | None = None
    blades_m: tuple[float, float] = (0.0, 0.0)
    clip: ClipKind | None = None

    @property
    def mouth_m(self) -> tuple[float, float]:
        """Return the length from the tip, and the width, over which the jaws do their deed."""
        return (self.clip.length_m, self.clip.width_m) if self.clip else self.blades_m

    @property
    def half_jaw_m(self) -> float:
        """Return half of the closed jaws' width along the tube, with their rounded edge."""
        return self.finger_half_width_m + self.finger_half_thickness_m

    @property
    def in_words(self) -> str:
        """Return the name in everyday words."""
        return self.name.replace("_", " ")


INSTRUMENTS: dict[str, Instrument] = {
    GRASPER: Instrument(  # ProGrasp
        name=GRASPER,
        arm="left",
        pitch_to_yaw_m=0.0107,
        yaw_to_tip_m=0.0286,
        wrist_pitch_limit_rad=radians(80),
        wrist_yaw_limit_rad=radians(80),
        jaw_range_rad=(radians(-20), radians(80)),
        finger_half_width_m=0.0025,  # pad dimensions of all three: assumed
        finger_half_thickness_m=0.0012,
        finger_start_m=0.008,
        jaw_torque_nm=0.16,  # assumed: 8 N at 20 mm
    ),
    CLIP_APPLIER: Instrument(  # large clip applier
        name=CLIP_APPLIER,
        deed="clip",
        clip=CLIPS[MEDIUM_LARGE_POLYMER],
        pitch_to_yaw_m=0.0107,
        yaw_to_tip_m=0.022,
        wrist_pitch_limit_rad=radians(70),
        wrist_yaw_limit_rad=radians(73),
        jaw_range_rad=(radians(-20), radians(45)),
        finger_half_width_m=0.0012,
        finger_half_thickness_m=0.0010,
        finger_start_m=0.007,
        jaw_torque_nm=0.4,  # assumed: 20 N at 20 mm
    ),
    SCISSORS: Instrument(  # curved scissors
        name=SCISSORS,
        deed="cut",
        blades_m=(BLADE_LENGTH_M, BLADE_WIDTH_M),
        pitch_to_yaw_m=0.0091,
        yaw_to_tip_m=0.0155,
        wrist_pitch_limit_rad=radians(80),
        wrist_yaw_limit_rad=radians(80),
        jaw_range_rad=(radians(-20), radians(80)),
        finger_half_width_m=0.0005,
        finger_half_thickness_m=0.0008,
        finger_start_m=0.004,
        jaw_torque_nm=0.2,  # assumed
    ),
    SLIM_CLIP_APPLIER: Instrument(  # small clip applier, for metal clips
        name=SLIM_CLIP_APPLIER,
        deed="clip",
        clip=CLIPS[MEDIUM_TITANIUM],
        pitch_to_yaw_m=0.0107,
        yaw_to_tip_m=0.022,
        wrist_pitch_limit_rad=radians(70),
        wrist_yaw_limit_rad=radians(73),
        jaw_range_rad=(radians(-20), radians(45)),
        finger_half_width_m=0.0008,  # assumed: the jaws are 3.0 mm wide in all
        finger_half_thickness_m=0.0007,  # assumed
        finger_start_m=0.007,
        jaw_torque_nm=0.4,  # assumed: as the other applier's
    ),
}


def right_tools() -> tuple[str, ...]:
    """Return the names of the right arm's tools, in the order of `INSTRUMENTS`."""
    return tuple(name for name, tool in INSTRUMENTS.items() if tool.arm == "right")


def appliers() -> tuple[Instrument, ...]:
    """Return the clip appliers, the one of the smallest clip first."""
    order = list(CLIPS.values())
    able = [tool for tool in INSTRUMENTS.values() if tool.clip]
    return tuple(sorted(able, key=lambda tool: order.index(clip_of(tool))))


def clip_of(tool: Instrument) -> ClipKind:
    """Return the kind of clip that an applier places.

    Raises:
        ValueError: The tool is no applier.
    """
    if tool.clip is None:
        raise ValueError(f"{tool.name!r} places no clip")
    return tool.clip


def applier_of(kind: ClipKind) -> Instrument:
    """Return the applier of a kind of clip.

    Raises:
        ValueError: No applier places this kind.
    """
    found = next((tool for tool in INSTRUMENTS.values() if tool.clip == kind), None)
    if found is None:
        raise ValueError(f"no applier places the clip {kind.name!r}")
    return found


def applier_for(diameter_m: float) -> Instrument:
    """Return the applier of the smallest clip for a vessel of this outer diameter."""
    return applier_of(kind_for(diameter_m))


@dataclass(frozen=True, kw_only=True)
class LinkPatches:
    """Contact surfaces of one instrument, a row per `PATCH_LINKS`, each in its own link frame.

    A patch is every point within `radius_m` of {a + t (b - a) + s w, t in [0, 1], s in [-1, 1]}.
    """

    a_link_m: Array  # (4, 3)
    b_link_m: Array  # (4, 3)
    w_link_m: Array  # (4, 3), zero for shaft and wrist, which are capsules
    radius_m: Array  # (4,)


def link_patches(instrument: Instrument) -> LinkPatches:
    """Return the patches of shaft, wrist, finger+ and finger-, for the link frames of `urdf.py`."""
    start, tip = instrument.finger_start_m, instrument.yaw_to_tip_m
    half = instrument.finger_half_thickness_m
    width = (instrument.finger_half_width_m, 0.0, 0.0)
    none = (0.0, 0.0, 0.0)
    return LinkPatches(
        a_link_m=np.array(
            [(0.0, 0.0, -SHAFT_PATCH_LENGTH_M), none, (0.0, half, start), (0.0, -half, start)]
        ),
        b_link_m=np.array(
            [none, (instrument.pitch_to_yaw_m, 0.0, 0.0), (0.0, half, tip), (0.0, -half, tip)]
        ),
        w_link_m=np.array([none, none, width, width]),
        radius_m=np.array([SHAFT_RADIUS_M, WRIST_RADIUS_M, half, half]),
    )
