"""Define the input of a planner's or controller's factory, and the declaration of privilege."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from planner.base import PLANNING_PERIOD_S
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.procedure import Procedure
from tissue_sim.constants import CONTROL_PERIOD_S

Factory = TypeVar("Factory", bound=Callable[..., Any])


@dataclass(frozen=True, kw_only=True)
class PolicySetup:
    """All that a policy may know before an episode begins, without the patient.

    Attributes:
        seed: Seed of the episode, from which the policy draws its own random numbers.
        checkpoint: File that the user named; None for the policy's own choice.
        cameras: Cameras whose pictures a controller finds in `Observation.images`.
        without_rules: Names of a controller's rules that are left out, to measure their worth.
        control_period_s: Time from one action to the next.
        planning_period_s: Time from one call of the planner to the next.
        procedure: The procedure of the episode.
    """

    seed: int = 0
    checkpoint: str | None = None
    cameras: tuple[str, ...] = ()
    without_rules: tuple[str, ...] = ()
    control_period_s: float = CONTROL_PERIOD_S
    planning_period_s: float = PLANNING_PERIOD_S
    procedure: Procedure = CHOLECYSTECTOMY

    def require_cameras(self, policy: str, names: Sequence[str]) -> None:
        """Check that the pictures of these cameras are available.

        Raises:
            ValueError: A camera is missing. The message names the policy.
        """
        if missing := [name for name in names if name not in self.cameras]:
            raise ValueError(
                f"{policy}: the policy was trained with {', '.join(names)};"
                f" name {', '.join(missing)} with --cameras, too"
            )


def privileged(factory: Factory) -> Factory:
    """Declare that a factory's policy reads the hidden state of the world.

    A privileged factory is called with the setup and the world; results mark it as privileged.
    """
    factory.privileged = True  # pyright: ignore[reportFunctionMemberAccess]
    return factory


def is_privileged(policy: object) -> bool:
    """Return whether a policy, or its factory, declares that it reads the hidden state."""
    return bool(getattr(policy, "privileged", False))
