"""What makes one episode."""

from collections.abc import Iterable
from dataclasses import dataclass

from scenarios.catalogue import CONTROLLERS, PLANNERS, SCENARIOS


@dataclass(frozen=True, kw_only=True)
class EpisodeConfig:
    """Names one episode whole: run it again and every step is the same.

    Attributes:
        scenario: A key of `scenarios.catalogue.SCENARIOS`.
        seed: Of the anatomy and of everything random; 0 or more.
        planner: A key of `scenarios.catalogue.PLANNERS`.
        controller: A key of `scenarios.catalogue.CONTROLLERS`.

    Raises:
        ValueError: For an unknown name or a seed that is not a whole number of at least 0.
    """

    scenario: str = "nominal"
    seed: int = 20_000
    planner: str = "scripted"
    controller: str = "expert"

    def __post_init__(self) -> None:
        _require_known("scenario", self.scenario, SCENARIOS)
        _require_known("planner", self.planner, PLANNERS)
        _require_known("controller", self.controller, CONTROLLERS)
        if not isinstance(self.seed, int) or self.seed < 0:
            raise ValueError(f"seed must be a whole number of at least 0, got {self.seed!r}")


def _require_known(role: str, name: str, allowed: Iterable[str]) -> None:
    if name not in allowed:
        raise ValueError(f"unknown {role} {name!r}; allowed: {', '.join(allowed)}")
