"""Label a motion with the correction that describes it, as SRT-H does.

The label is the arm and endoscope axis whose change over the window is the largest multiple of its
threshold. Jaws count when no arm moves beyond its threshold. SRT-H uses 10 samples at 30 Hz; here
the window is the next second, in which the planner's instruction holds. Thresholds are SRT-H's (lab
code); the jaws' threshold is the middle of its range.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE
from tissue_sim.frames import Array

WINDOW_STEPS = 30
THRESHOLDS_M = {"left": (0.5e-3, 0.5e-3, 0.8e-3), "right": (1.0e-3, 0.8e-3, 1.5e-3)}
THRESHOLD_RAD = 0.25
ARMS = ("left", "right")
_TEXTS = {(c.arm, c.direction, c.jaw): c.text for c in CORRECTIONS}


def correction_of(moved_m: Array, opened_rad: Array) -> str:
    """Return the correction that describes a motion; "" if nothing moves enough.

    Args:
        moved_m: (2, 3) motion of left and right tip, endoscope frame.
        opened_rad: (2,) opening of the jaws; negative means closing.
    """
    return _direction_text(moved_m) or _jaw_text(opened_rad)


def first_correction_of(motions: Iterable[tuple[Array, Array]]) -> str:
    """Return the correction of the first motion that has one; "" if none has."""
    return next(filter(None, (correction_of(*motion) for motion in motions)), "")


def _direction_text(moved_m: Array) -> str:
    share: dict[str, float] = {}
    for arm, moved in zip(ARMS, moved_m, strict=True):
        for direction, along in DIRECTION_ENDOSCOPE.items():
            threshold_m = float(np.abs(along) @ THRESHOLDS_M[arm])
            share[_TEXTS[arm, direction, None]] = float(np.dot(along, moved)) / threshold_m
    best = max(share, key=share.__getitem__)
    return best if share[best] >= 1.0 else ""


def _jaw_text(opened_rad: Array) -> str:
    motions = {
        arm: "open" if opened > 0.0 else "close"
        for arm, opened in zip(ARMS, opened_rad, strict=True)
        if abs(opened) >= THRESHOLD_RAD
    }
    if not motions:
        return ""
    if len(motions) == 2 and len(set(motions.values())) == 1:
        return _TEXTS["both", None, motions["left"]]
    arm = ARMS[int(np.argmax(np.abs(opened_rad)))]
    return _TEXTS[arm, None, motions[arm]]
