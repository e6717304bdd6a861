"""Who acts in an episode, its whole configuration, and the digests of its checkpoints."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from hashlib import sha256
from importlib import import_module
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from scenarios.catalogue import (
    ABLATIONS,
    CHOLECYSTECTOMY,
    CHUNK_RULES,
    CONTROLLERS,
    PEOPLE,
    PLANNERS,
    PROCEDURES,
    RULED,
    SCENARIOS,
    SENSE_OF,
    SENSES,
    PolicyEntry,
    SenseEntry,
    learned,
    policy_named,
)
from scenarios.perturbation.perturbation import Perturbation
from scenarios.perturbation.perturbations import AT_TASKS
from tissue_sim.sensing.glance import CAMERA_NAMES


@dataclass(frozen=True, kw_only=True)
class Stack:
    """Who plans, who moves, how both observe, and what else acts or is left out.

    Attributes:
        planner: A key of `scenarios.catalogue.PLANNERS`, or MODULE:FACTORY.
        controller: A key of `scenarios.catalogue.CONTROLLERS`, or MODULE:FACTORY.
        sense: A key of `scenarios.catalogue.SENSES`, or MODULE:FACTORY: how planner, controller and
            filter observe the world.
        checkpoint: File of a learned controller; None for the one that comes with Calot,
            if there is one.
        planner_checkpoint: File of a learned planner; None likewise.
        perception_checkpoint: File of the perception, for the senses "cameras" and "endoscope";
            None likewise.
        safety_filter: Whether commands pass through the safety filter.
        ablation: A key of `scenarios.catalogue.ABLATIONS`; None for no ablation.
        person: A key of `scenarios.catalogue.PEOPLE`, who watches and corrects; None for nobody.
        cameras: Names (`tissue_sim.sensing.glance`) of the cameras whose pictures
            the controller gets besides.
        without_rules: Of `scenarios.catalogue.CHUNK_RULES`, those that the learned controller goes
            without.

    Raises:
        ValueError: For an unknown name, or a checkpoint for a policy that takes none.
    """

    planner: str = "scripted"
    controller: str = "expert"
    sense: str = "tracked"
    checkpoint: str | None = None
    planner_checkpoint: str | None = None
    perception_checkpoint: str | None = None
    safety_filter: bool = True
    ablation: str | None = None
    person: str | None = None
    cameras: tuple[str, ...] = ()
    without_rules: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for role, known in (("planner", PLANNERS), ("controller", CONTROLLERS), ("sense", SENSES)):
            _require_named(role, getattr(self, role), known)
        if self.ablation is not None:
            _require_known("ablation", self.ablation, ABLATIONS)
        if self.person is not None:
            _require_known("person", self.person, PEOPLE)
        if isinstance(self.cameras, str):
            raise ValueError(f"cameras must be a tuple of names, got {self.cameras!r}")
        for camera in self.cameras:
            _require_known("camera", camera, CAMERA_NAMES)
        for rule in self.without_rules:
            _require_known("rule", rule, CHUNK_RULES)
        if self.without_rules and self.controller != RULED:
            raise ValueError(f"without_rules: only the controller {RULED!r} has rules")
        _require_learned("sense", self.sense, self.perception_checkpoint, SENSES)
        _require_learned("controller", self.controller, self.checkpoint, CONTROLLERS)
        _require_learned("planner", self.planner, self.planner_checkpoint, PLANNERS)

    @property
    def stack(self) -> dict[str, Any]:
        """Return the fields of the stack alone, by name."""
        return {part.name: getattr(self, part.name) for part in fields(Stack)}

    @property
    def outside(self) -> dict[str, str]:
        """Return what is none of Calot's own, and may do anything to its process, by its role."""
        named = {"planner": self.planner, "controller": self.controller, "sense": self.sense}
        return {role: name for role, name in named.items() if ":" in name}


@dataclass(frozen=True, kw_only=True)
class EpisodeConfig(Stack):
    """The complete configuration of one episode: a second run repeats every step.

    Attributes:
        scenario: A key of `scenarios.catalogue.SCENARIOS`.
        procedure: A key of `scenarios.catalogue.PROCEDURES`, or MODULE:PROCEDURE.
        magnitude: Strength of the scenario's one perturbation, in its unit; None leaves it at the
            scenario's own.
        seed: Seed of the anatomy and of everything random; 0 or more.
        task_cap_s: Simulated time after which a task, and with it the episode, fails; the default
            is that of SRT-H.
        instruct: File of what a person says and when; None if nobody says anything.
        act_limit_s: Wall time for each `act` of the controller; more is an error of the episode.
            None for no limit.

    Raises:
        ValueError: As for `Stack`; the policies do not know the procedure. The scenario does not
            allow the magnitude, or means nothing with the sense. The seed is not a whole number of
            at least 0. A cap or limit is not a number above 0.
    """

    scenario: str = "nominal"
    procedure: str = CHOLECYSTECTOMY
    magnitude: float | None = None
    seed: int = 20_054  # an operable patient
    task_cap_s: float = 90.0
    instruct: str | None = None
    act_limit_s: float | None = None

    def __post_init__(self) -> None:
        _require_known("scenario", self.scenario, SCENARIOS)
        _require_named("procedure", self.procedure, PROCEDURES, "MODULE:PROCEDURE")
        super().__post_init__()
        if self.procedure != CHOLECYSTECTOMY:
            _require_any_procedure("planner", self.planner, PLANNERS)
            _require_any_procedure("controller", self.controller, CONTROLLERS)
            _require_any_task(self.scenario)
        if self.sense != (needed := SENSE_OF.get(self.scenario, self.sense)):
            raise ValueError(f"scenario {self.scenario!r} needs the sense {needed!r}")
        if self.magnitude is not None and not _is_number(self.magnitude, Real):
            raise ValueError(f"magnitude must be a number, got {self.magnitude!r}")
        _ = self.perturbations
        if not _is_number(self.seed, Integral) or self.seed < 0:
            raise ValueError(f"seed must be a whole number of at least 0, got {self.seed!r}")
        object.__setattr__(self, "seed", int(self.seed))  # of numpy, too
        _require_time("task_cap_s", self.task_cap_s)
        if self.act_limit_s is not None:
            _require_time("act_limit_s", self.act_limit_s)

    @property
    def outside(self) -> dict[str, str]:
        """Return what is none of Calot's own, and may do anything to its process, by its role."""
        own = ":" not in self.procedure
        return super().outside | ({} if own else {"procedure": self.procedure})

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


def _require_named(
    role: str, name: str, allowed: Iterable[str], other: str = "MODULE:FACTORY"
) -> None:
    if ":" not in name:
        _require_known(role, name, (*allowed, other))


def _require_any_procedure(role: str, name: str, known: Mapping[str, PolicyEntry]) -> None:
    if name in known and not known[name].any_procedure:
        able = ", ".join(n for n, policy in known.items() if policy.any_procedure)
        raise ValueError(
            f"{role} {name!r} knows the procedure {CHOLECYSTECTOMY!r} alone; these know any: {able}"
        )


def _require_any_task(scenario: str) -> None:
    bound = [p.name for p in AT_TASKS]
    if scenario in bound:
        able = ", ".join(name for name in SCENARIOS if name not in bound)
        raise ValueError(
            f"scenario {scenario!r} strikes a task of {CHOLECYSTECTOMY!r}; these do not: {able}"
        )


def _require_learned(
    role: str, name: str, checkpoint: str | None, known: Mapping[str, PolicyEntry | SenseEntry]
) -> None:
    able = learned(known)
    if checkpoint is not None and name not in able and ":" not in name:
        raise ValueError(f"{role} {name!r} takes no checkpoint; these do: {', '.join(able)}")


def checkpoint_digests(config: EpisodeConfig) -> dict[str, str]:
    """Return the SHA-256 of each checkpoint used, by `controller`, `planner` and `perception`.

    Raises:
        CheckpointError: No checkpoint is named, and none is shipped.
        OSError: A checkpoint cannot be read.
    """
    sense = SENSES.get(config.sense)
    named = {
        "controller": (config.checkpoint, policy_named(config.controller).checkpoint),
        "planner": (config.planner_checkpoint, policy_named(config.planner).checkpoint),
        "perception": (config.perception_checkpoint, sense.checkpoint if sense else None),
    }
    files = {
        role: import_module(module).CHECKPOINTS.chosen(file) if module else file
        for role, (file, module) in named.items()
    }
    return {role: sha256(Path(f).read_bytes()).hexdigest() for role, f in files.items() if f}
