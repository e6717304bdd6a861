"""The interface of every planner, and the periods that planners share."""

from typing import Protocol, TypeVar

from planner.instruction import Instruction

PLANNING_PERIOD_S = 1.0  # of simulated time, from one question to the planner to the next
PATIENCE_S = 12.0  # a clip or a cut that has not succeeded by then is tried again

Observation_contra = TypeVar("Observation_contra", contravariant=True)


class Planner(Protocol[Observation_contra]):
    """Gives the next instruction, once in each planning period of simulated time.

    Attributes:
        hears_of_success: it is also asked as soon as a task succeeds; only if privileged.
    """

    @property
    def hears_of_success(self) -> bool: ...

    def reset(self) -> None:
        """Forget the episode so far."""
        ...

    def plan(self, observation: Observation_contra) -> Instruction:
        """Return what should be done now, from the present and the past observations."""
        ...
