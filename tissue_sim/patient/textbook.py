"""Draw textbook patients: long tubes, one artery, on which three clips and a cut always fit.

These patients are those of world versions 1 to 5, except for their shortest arteries. Tests of
tools and tissue, and the first lessons of a policy, need patients whose geometry does not decide
the outcome. They are no sample of any population: see `tissue_sim.patient.population` for such a
sample.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tissue_sim.patient.anatomy import Anatomy, require_seed
from tissue_sim.patient.population import MOST_REMNANTS, TINTS, Bounds, tint

TEXTBOOK: dict[str, Bounds] = {  # assumed; drawn in this order
    "gallbladder_length_m": (0.060, 0.100),
    "gallbladder_width_m": (0.025, 0.040),
    "duct_length_m": (0.020, 0.040),
    "duct_diameter_m": (0.002, 0.004),
    "duct_angle_rad": (0.15, 0.50),
    "duct_slack": (0.02, 0.07),
    "artery_length_m": (0.0165, 0.030),
    "artery_diameter_m": (0.0012, 0.0025),
    "artery_angle_rad": (0.20, 0.55),
    "artery_slack": (0.02, 0.07),
    "artery_depth_m": (-0.004, 0.004),
    "artery_insertion_m": (0.006, 0.011),
    "bed_tilt_rad": (0.50, 0.90),
    "stiffness_scale": (0.5, 2.0),
    "endoscope_pitch_rad": (0.54, 0.68),
    "endoscope_yaw_rad": (-0.08, 0.08),
    "endoscope_distance_m": (0.080, 0.095),
}
SWAPPED_SHARE = 0.15  # assumed: more than in the population, so that both sides are practised


def textbook_from_seed(seed: int) -> Anatomy:
    """Return the textbook patient of a seed.

    Raises:
        ValueError: the seed is not a non-negative integer.
    """
    rng = np.random.default_rng([0xCA107, require_seed(seed)])
    drawn: dict[str, Any] = {name: float(rng.uniform(*b)) for name, b in TEXTBOOK.items()}
    remnants = int(rng.integers(MOST_REMNANTS, endpoint=True))
    on_left = bool(rng.random() < SWAPPED_SHARE)
    drawn |= {name: tint(rng, colour) for name, colour in TINTS.items()}
    return Anatomy(
        seed=int(seed),
        **drawn,
        artery_turn_rad=0.0,
        remnants=remnants,
        fat_strands=0,
        fat_lobules=0,
        lymph_node=False,
        artery_on_left=on_left,
    )
