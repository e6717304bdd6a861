"""What a perturbation can do to an episode, and the list of what it did."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controller.action import ToolAction
from planner.task import Task
from scenarios.perturbation.perturbation import AtTask, AtTime, Moment, Perturbation
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.world import World


@dataclass(frozen=True, kw_only=True)
class Applied:
    """A perturbation set in: which, when (simulated time) and how strong."""

    name: str
    time_s: float
    magnitude: float
    unit: str


class Effect:
    """Applies one perturbation to one episode; this one leaves everything as it is.

    Attributes:
        magnitude: in the perturbation's unit, above 0.
        at: when it begins.
        applied: what it did so far.
    """

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        self._perturbation = perturbation
        self.magnitude = perturbation.magnitude
        self.at = perturbation.at or self.drawn_moment(rng)
        self.applied: list[Applied] = []

    def drawn_moment(self, rng: np.random.Generator) -> Moment:
        """When it begins, where that is not set; the start of the episode."""
        del rng
        return AtTime(time_s=0.0)

    def on_anatomy(self, anatomy: Anatomy) -> Anatomy:
        """The patient to operate on."""
        return anatomy

    def lead(self, world: World, task: Task) -> ToolAction | None:
        """The next motion while the arms are led astray; None while the controller has them."""
        del world, task
        return None

    def on_action(self, action: ToolAction, world: World) -> ToolAction:
        """What reaches the driver of a controller's action."""
        del world
        return action

    def before_step(self, world: World, task: Task) -> None:
        """Change the world before its next control step, tool exchanges included."""

    def due(self, world: World, task: Task) -> bool:
        """Whether its moment has come."""
        if isinstance(self.at, AtTask):
            return task.index == self.at.index
        return world.record.time_s >= self.at.time_s - 1e-9

    def note(self, time_s: float) -> None:
        """Remember that it set in."""
        p = self._perturbation
        self.applied.append(Applied(name=p.name, time_s=time_s, magnitude=p.magnitude, unit=p.unit))
