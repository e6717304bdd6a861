"""The interface of the senses: from the world to what everybody who acts is told.

`exact` is simulator state (`exact.py`), which no robot has. `tracked` (`tracked.py`) models what
cameras and encoders tell, and needs no pictures. `cameras` is perception from pictures, and
`endoscope` is the same without the wrists' cameras.
"""

from __future__ import annotations

from typing import Protocol

from tissue_sim.sensing.observation import Observation
from tissue_sim.world import World


class Sense(Protocol):
    """Observes one patient, once in each control step."""

    def observe(self, world: World, exact: Observation) -> Observation:
        """Return what is sensed now; `exact` is the world's exact state now."""
        ...
