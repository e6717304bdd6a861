"""How large are the errors of what cameras and encoders tell? The parameters of `tracked`.

Errors of the places of points were fitted to those of the perception from pictures, on eight
tuning patients (`docs/senses.md`); what is of encoders and motor currents is assumed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

ABOVE_0, SHARE = "above 0", "from 0 to 1"
ALLOWED = {"slow_s": ABOVE_0, "look_s": ABOVE_0, "dropout_s": ABOVE_0, "dropout": SHARE}


@dataclass(frozen=True, kw_only=True)
class SensorModel:
    """Errors, each a standard deviation along each axis unless said otherwise.

    Attributes:
        shared_m: all points and both tips together, constant in an episode: the arms' places
            relative to the endoscope are off, and cameras on the arms see by them.
        scene_m: all points together, constant in an episode.
        bias_m: each line of points, constant in an episode; neighbours have nearly the same.
        slow_m, slow_s: the same, but wandering with this time constant.
        white_m: each point, new in each look.
        along_m: each end of a line along it, constant: a smooth tube has no landmark.
        far: factor on `bias_m`, `slow_m` and `along_m` from `BLURRED_M` to the right tip on.
        clip_m: each clip, constant.
        tube_radius, sac_radius: of a tube's radius and the gallbladder's, relative.
        look_s: time from one look to the next.
        delay_s: age of what a look shows.
        dropout: share of looks in which a point that is in sight is not found.
        dropout_s: how long a dropout lasts on average.
        creep_m_s, creep_most_m: growth of a hidden point's standard deviation, and its end: it
            moves with its neighbours.
        severed_s: how long after a cut the tube counts as severed.
        third_tube: error of the chance of a third tube.
        hand_eye_m, hand_eye_rad: of each arm's pose relative to what is seen, constant.
        tip_m, jaw_rad: of encoders, white.
        force_n: slow error of a force, N, with `slow_s`; a tenth of it is white.
    """

    shared_m: float = 5e-5
    scene_m: float = 1e-4
    bias_m: float = 1.6e-4
    slow_m: float = 1.6e-4
    slow_s: float = 5.0
    white_m: float = 2e-5
    along_m: float = 1e-4
    far: float = 1.5
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
        """Return the model with all errors, but not its times, `strength` times as large."""
        sizes = {name: strength * getattr(self, name) for name in SIZES}
        return replace(self, **sizes, far=1.0 + (self.far - 1.0) * min(strength, 1.0))


SIZES = (
    "shared_m", "scene_m", "bias_m", "slow_m", "white_m", "along_m", "clip_m", "tube_radius",
    "sac_radius",
    "third_tube", "hand_eye_m", "hand_eye_rad", "tip_m", "jaw_rad", "force_n",
)  # fmt: skip
SHARP_M, BLURRED_M = 0.015, 0.045  # from the right tip: its camera sees close to it best
