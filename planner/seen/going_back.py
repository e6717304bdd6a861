"""What of a task has been done, as the robot sees it. From the observation alone."""

from __future__ import annotations

from tissue_sim.sensing.observation import Observation, tip_to_tubes_m
from tissue_sim.thresholds import RETRACTED_M


def is_back(seen: Observation) -> bool:
    """Return whether the right tip is seen as far from both tubes as going back asks for."""
    return tip_to_tubes_m(seen) >= RETRACTED_M
