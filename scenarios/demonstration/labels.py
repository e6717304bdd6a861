"""Label a motion with the correction that describes it, as SRT-H does.

The label is the arm and endoscope axis whose change over the window is the largest multiple of its
threshold. Jaws count when no arm moves beyond its threshold. SRT-H uses 10 samples at 30 Hz; here
the window is the next second, in which the planner's instruction holds. Thresholds are SRT-H's (lab
code); the jaws' threshold is the middle of its range.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from controller.dataset.schema import UNNAMED
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE, Correction
from planner.correction_way import moved_m, opened_rad
from tissue_sim.frames import Array

WINDOW_STEPS = 30
THRESHOLDS_M = {"left": (0.5e-3, 0.5e-3, 0.8e-3), "right": (1.0e-3, 0.8e-3, 1.5e-3)}
THRESHOLD_RAD = 0.25
ARMS = ("left", "right")
FARTHEST_M = 0.02  # that a correction asks for
_TEXTS = {(c.arm, c.direction, c.jaw): c.text for c in CORRECTIONS}
_CORRECTION = {c.text: c for c in CORRECTIONS}


def correction_of(moved: Array, opened: Array) -> str:
    """Return the correction that describes a motion; "" if nothing moves enough.

    Args:
        moved: (2, 3) motion of left and right tip, endoscope frame, m.
        opened: (2,) opening of the jaws, rad; negative means closing.
    """
    return _direction_text(moved) or _jaw_text(opened)


@dataclass(frozen=True, kw_only=True)
class Advice:
    """A correction that would ask for a motion; "" for none.

    Attributes:
        correction: One of the 18 corrections, or "".
        left: Its distance, m, and its opening of the jaws, rad; `UNNAMED` for what it lacks.
    """

    correction: str = ""
    left: tuple[float, float] = (UNNAMED, UNNAMED)


SILENCE = Advice()


def advice_from(motions: Iterable[tuple[Array, Array]]) -> Advice:
    """Return the correction of the first motion that has one, as far as this motion goes."""
    for moved, opened in motions:
        if text := correction_of(moved, opened):
            return _as_far(_CORRECTION[text], moved, opened)
    return SILENCE


def _as_far(correction: Correction, moved: Array, opened: Array) -> Advice:
    if correction.direction is None:
        return Advice(correction=correction.text, left=(UNNAMED, opened_rad(correction, opened)))
    far_m = min(moved_m(correction, moved), FARTHEST_M)
    return Advice(correction=correction.text, left=(far_m, UNNAMED))


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
