"""Define the interface of the senses: from the world to the observation of all that act.

`exact` is simulator state (`exact.py`), which no robot has. `tracked` (`tracked.py`) models cameras
and encoders, and needs no pictures. `cameras` is perception from pictures, and `endoscope` is the
same perception without the wrists' cameras.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from tissue_sim.sensing.observation import Observation

if TYPE_CHECKING:
    from tissue_sim.world import World


class Sense(Protocol):
    """Observes one patient, once in each control step."""

    def observe(self, world: World, exact: Observation) -> Observation:
        """Return the current observation; `exact` is the world's current exact state."""
        ...
