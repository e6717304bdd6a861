"""Define the interface of the senses: from the world to the observation of all that act.

`exact` is simulator state (`exact.py`), which no robot has. `tracked` (`tracked.py`) models cameras
and encoders, and needs no pictures. `cameras` is perception from pictures, and `endoscope` is the
same perception without the wrists' cameras.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.sensor_model import SensorModel

if TYPE_CHECKING:
    from tissue_sim.world import World


@dataclass(frozen=True, kw_only=True)
class SenseSetup:
    """The argument of a sense's factory.

    Attributes:
        seed: of the episode; a sense draws its own errors from it.
        checkpoint: file of a perception that the user named; None for the sense's own choice.
        model: errors of encoders, currents and points in this episode.
        spoil: what the episode's perturbations do to a picture.
    """

    seed: int = 0
    checkpoint: str | None = None
    model: SensorModel = field(default_factory=SensorModel)
    spoil: Callable[..., Any] | None = None


class Sense(Protocol):
    """Observes one patient, once in each control step."""

    def observe(self, world: World, exact: Observation) -> Observation:
        """Return the current observation; `exact` is the world's current exact state."""
        ...
