"""What every planner can do."""

from typing import Protocol, TypeVar

from planner.instruction import Instruction

PLANNING_PERIOD_S = 1.0  # of simulated time, from one question to the planner to the next
PATIENCE_S = 12.0  # a clip or a cut that has not succeeded by then is tried again

Observation_contra = TypeVar("Observation_contra", contravariant=True)


class Planner(Protocol[Observation_contra]):
    """Says what to do next, about once a second of simulated time.

    Attributes:
        hears_of_success: it is also asked as soon as a task is done; only for the privileged.
    """

    @property
    def hears_of_success(self) -> bool: ...

    def reset(self) -> None:
        """Forgets the episode so far."""
        ...

    def plan(self, observation: Observation_contra) -> Instruction:
        """Returns what should be done now, from what is seen now and was seen before."""
        ...
