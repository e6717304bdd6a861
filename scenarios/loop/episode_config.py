"""The configuration of one episode."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from numbers import Integral, Real

from scenarios.catalogue import (
    ABLATIONS,
    CONTROLLERS,
    LEARNED_CONTROLLERS,
    LEARNED_PLANNERS,
    PEOPLE,
    PERCEIVING,
    PLANNERS,
    SCENARIOS,
    SENSE_OF,
    SENSES,
)
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.sensing.pictures.camera_names import CAMERA_NAMES


@dataclass(frozen=True, kw_only=True)
class EpisodeConfig:
    """The complete configuration of one episode: a second run repeats every step.

    Attributes:
        scenario: A key of `scenarios.catalogue.SCENARIOS`.
        magnitude: Strength of the scenario's one perturbation, in its unit; None leaves it at the
            scenario's own.
        seed: Seed of the anatomy and of everything random; 0 or more.
        planner: A key of `scenarios.catalogue.PLANNERS`, or MODULE:FACTORY.
        controller: A key of `scenarios.catalogue.CONTROLLERS`, or MODULE:FACTORY.
        sense: A key of `scenarios.catalogue.SENSES`: how everybody who acts observes the world.
        perception_checkpoint: File of the perception, for the senses "cameras" and "endoscope";
            None for the one that comes with Calot.
        task_cap_s: Simulated time after which a task, and with it the episode, fails; the default
            is that of SRT-H.
        checkpoint: File of a learned controller; None for the one that comes with Calot.
        planner_checkpoint: File of a learned planner; None likewise.
        safety_filter: Whether commands pass through the safety filter.
        instruct: File of what a person says and when; None if nobody says anything.
        person: A key of `scenarios.catalogue.PEOPLE`, who watches and corrects; None for nobody.
        cameras: Names (`tissue_sim.sensing.pictures.camera_names`) of those whose pictures the
            controller gets besides.
        ablation: A key of `scenarios.catalogue.ABLATIONS`; None for no ablation.
        act_limit_s: Wall time for each `act` of the controller; more is an error of the episode.
            None for no limit.

    Raises:
        ValueError: For an unknown name, a magnitude that the scenario does not allow, a checkpoint
            for a policy that takes none, larger errors of a sense that has none, a seed that is
            not a whole number of at least 0, or a cap or limit that is not a number above 0.
    """

    scenario: str = "nominal"
    magnitude: float | None = None
    seed: int = 20_054  # an operable patient
    planner: str = "learned"
    controller: str = "diffusion"
    sense: str = "tracked"
    perception_checkpoint: str | None = None
    checkpoint: str | None = None
    planner_checkpoint: str | None = None
    task_cap_s: float = 90.0
    safety_filter: bool = True
    instruct: str | None = None
    ablation: str | None = None
    person: str | None = None
    cameras: tuple[str, ...] = ()
    act_limit_s: float | None = None

    def __post_init__(self) -> None:
        _require_known("scenario", self.scenario, SCENARIOS)
        _require_policy("planner", self.planner, PLANNERS)
        _require_policy("controller", self.controller, CONTROLLERS)
        _require_known("sense", self.sense, SENSES)
        _require_learned("sense", self.sense, self.perception_checkpoint, PERCEIVING)
        if self.sense != (needed := SENSE_OF.get(self.scenario, self.sense)):
            raise ValueError(f"scenario {self.scenario!r} needs the sense {needed!r}")
        if self.ablation is not None:
            _require_known("ablation", self.ablation, ABLATIONS)
        if self.person is not None:
            _require_known("person", self.person, PEOPLE)
        if isinstance(self.cameras, str):
            raise ValueError(f"cameras must be a tuple of names, got {self.cameras!r}")
        for camera in self.cameras:
            _require_known("camera", camera, CAMERA_NAMES)
        if self.magnitude is not None and not _is_number(self.magnitude, Real):
            raise ValueError(f"magnitude must be a number, got {self.magnitude!r}")
        _ = self.perturbations
        _require_learned("controller", self.controller, self.checkpoint, LEARNED_CONTROLLERS)
        _require_learned("planner", self.planner, self.planner_checkpoint, LEARNED_PLANNERS)
        if not _is_number(self.seed, Integral) or self.seed < 0:
            raise ValueError(f"seed must be a whole number of at least 0, got {self.seed!r}")
        object.__setattr__(self, "seed", int(self.seed))  # of numpy, too
        _require_time("task_cap_s", self.task_cap_s)
        if self.act_limit_s is not None:
            _require_time("act_limit_s", self.act_limit_s)

    @property
    def has_outside_policy(self) -> bool:
        """Return whether a policy is none of Calot's own, and may do anything to its process."""
        return ":" in self.planner or ":" in self.controller

    @property
    def perturbations(self) -> tuple[Perturbation, ...]:
        """Return the scenario's perturbations, at the configured magnitude."""
        own = SCENARIOS[self.scenario].perturbations
        if self.magnitude is None:
            return own
        if len(own) != 1:
            able = [name for name, s in SCENARIOS.items() if len(s.perturbations) == 1]
            raise ValueError(
                f"scenario {self.scenario!r} takes no magnitude; these do: {', '.join(able)}"
            )
        return (replace(own[0], magnitude=self.magnitude),)


def _is_number(value: object, kind: type) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool)


def _require_time(name: str, time_s: float) -> None:
    if not _is_number(time_s, Real) or not 0.0 < time_s < math.inf:
        raise ValueError(f"{name} must be a number above 0, got {time_s!r}")


def _require_known(role: str, name: str, allowed: Iterable[str]) -> None:
    if name not in allowed:
        raise ValueError(f"unknown {role} {name!r}; allowed: {', '.join(allowed)}")


def _require_policy(role: str, name: str, allowed: Iterable[str]) -> None:
    if ":" not in name:
        _require_known(role, name, (*allowed, "MODULE:FACTORY"))


def _require_learned(role: str, name: str, checkpoint: str | None, learned: Iterable[str]) -> None:
    if checkpoint is not None and name not in learned and ":" not in name:
        raise ValueError(f"{role} {name!r} takes no checkpoint; these do: {', '.join(learned)}")
