"""How large are the errors of camera and encoder values? These are the parameters of `tracked`.

The errors of points' places were fitted to those of the perception from pictures, on eight tuning
patients (`docs/senses.md`). The errors of encoders and motor currents are assumed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Rgb = NDArray[np.uint8]  # picture (height, width, 3)
PictureFault = Callable[[str, Rgb], Rgb]  # from a camera's name and picture to the faulty picture

ABOVE_0, SHARE = "above 0", "from 0 to 1"
ALLOWED = {"slow_s": ABOVE_0, "look_s": ABOVE_0, "dropout_s": ABOVE_0, "dropout": SHARE}


@dataclass(frozen=True, kw_only=True)
class SensorModel:
    """Errors, each a standard deviation along each axis unless stated otherwise.

    Attributes:
        shared_m: Error of all points and both tips together, constant in an episode. It is an error
            of the arms' places relative to the endoscope, which also shifts the cameras on the
            arms.
        scene_m: Error of all points together, constant in an episode.
        bias_m: Error of each line of points, constant in an episode; neighbours have nearly the
            same error.
        slow_m, slow_s: Error like `bias_m` that drifts, and the time constant of the drift.
        white_m: Error of each point, new in each look.
        along_m: Error of each end of a line along it, constant, because a smooth tube has no
            landmark.
        far: Factor on `bias_m`, `slow_m` and `along_m` from `BLURRED_M` to the right tip on.
        covered: Factor on the same errors of the structures at risk. A surgeon leaves the
            peritoneum over them and sees its bulge, which tells little of how deep they lie.
        clip_m: Error of each clip, constant.
        tube_radius, sac_radius: Relative errors of a tube's radius and the gallbladder's radius.
        look_s: Time between two looks.
        delay_s: Age of a look's content.
        dropout: Share of looks in which a visible point is not found.
        dropout_s: Average duration of a dropout.
        creep_m_s, creep_most_m: Growth of a hidden point's standard deviation, and its largest
            value. A hidden point moves with its neighbours.
        severed_s: Delay after a cut until the tube counts as severed.
        third_tube: Error of the probability of a third tube.
        hand_eye_m, hand_eye_rad: Errors of each arm's pose relative to the observed scene,
            constant.
        tip_m, jaw_rad: White errors of encoders.
        force_n: Slow error of a force, N, with `slow_s`; a tenth of the error is white.
    """

    shared_m: float = 5e-5
    scene_m: float = 1e-4
    bias_m: float = 1.6e-4
    slow_m: float = 1.6e-4
    slow_s: float = 5.0
    white_m: float = 2e-5
    along_m: float = 1e-4
    far: float = 1.5
    covered: float = 2.5  # assumed: 0.6 to 0.9 mm, about half the hepatic artery's radius
    clip_m: float = 1.9e-4
    tube_radius: float = 0.2
    sac_radius: float = 0.06
    look_s: float = 0.1
    delay_s: float = 0.067
    dropout: float = 0.03
    dropout_s: float = 0.3
    creep_m_s: float = 1e-3
    creep_most_m: float = 3e-3
    severed_s: float = 0.3
    third_tube: float = 0.15
    hand_eye_m: float = 1e-4
    hand_eye_rad: float = 5e-3
    tip_m: float = 3e-5
    jaw_rad: float = 2e-3
    force_n: float = 0.05

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            allowed = ALLOWED.get(name, "of 0 or more")
            above = value > 0.0 if allowed == ABOVE_0 else value >= 0.0
            if not above or value == math.inf or (allowed == SHARE and value > 1.0):
                raise ValueError(f"sensor model: {name} = {value!r} must be a number {allowed}")

    def scaled(self, strength: float) -> SensorModel:
        """Return the model with errors `strength` times as large, and the same times."""
        sizes = {name: strength * getattr(self, name) for name in SIZES}
        factors = {name: 1.0 + (getattr(self, name) - 1.0) * min(strength, 1.0) for name in FACTORS}
        return replace(self, **sizes, **factors)


SIZES = (
    "shared_m", "scene_m", "bias_m", "slow_m", "white_m", "along_m", "clip_m", "tube_radius",
    "sac_radius",
    "third_tube", "hand_eye_m", "hand_eye_rad", "tip_m", "jaw_rad", "force_n",
)  # fmt: skip
FACTORS = "far", "covered"
SHARP_M, BLURRED_M = 0.015, 0.045  # from the right tip: its camera resolves close points best


@dataclass(frozen=True, kw_only=True)
class SenseSetup:
    """The argument of a sense's factory.

    Attributes:
        seed: of the episode; a sense draws its own errors from it.
        checkpoint: file of a perception that the user named; None for the sense's own choice.
        model: errors of encoders, currents and points in this episode.
        picture_fault: what the episode's perturbations do to a picture; None for nothing.
    """

    seed: int = 0
    checkpoint: str | None = None
    model: SensorModel = field(default_factory=SensorModel)
    picture_fault: PictureFault | None = None
