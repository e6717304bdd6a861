"""What of a task has been done, as the robot sees it. From the observation alone."""

from __future__ import annotations

from tissue_sim.sensing.observation import Observation, tip_to_tubes_m
from tissue_sim.thresholds import RETRACTED_M

BEYOND_M = 3e-4  # the observed points bend less than the tube
SURE = 1.0  # standard deviations of the tubes' places


def is_back(seen: Observation) -> bool:
    """Return whether the right tip is surely as far from both tubes as going back asks for."""
    unsure_m = SURE * float(seen.std_m[: len(seen.left_tube_m) + len(seen.right_tube_m)].mean())
    return tip_to_tubes_m(seen) >= RETRACTED_M + BEYOND_M + unsure_m
