"""The base classes of a perturbation's effect on an episode."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from controller.action import ToolAction
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.outcomes import is_needed
from planner.procedure.task import Task
from scenarios.perturbation.perturbation import AtTask, AtTime, Onset, Perturbation
from tissue_sim.frames import Array
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.sensing.sensor_model import SensorModel

if TYPE_CHECKING:
    from tissue_sim.world import World

EARLIEST_S, LATEST_S = 5.0, 60.0  # assumed; a quick procedure is over before the latest


@dataclass(frozen=True, kw_only=True)
class Applied:
    """The onset of a perturbation: its name, its simulated time and its magnitude."""

    name: str
    time_s: float
    magnitude: float
    unit: str


class Effect:
    """Applies one perturbation to one episode; this base class changes nothing.

    Attributes:
        tasks: Indices of the tasks in which it may begin; () for the start of the episode.
        magnitude: In the perturbation's unit, above 0.
        at: The onset; None until a task is chosen among those that the patient needs.
        applied: Its onsets so far.
    """

    tasks: ClassVar[tuple[int, ...]] = ()

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        self._perturbation = perturbation
        self.magnitude = perturbation.magnitude
        self.at = perturbation.at or self.drawn_onset(rng)
        self._share = float(rng.random()) if self.at is None else 0.0
        self.applied: list[Applied] = []

    def drawn_onset(self, rng: np.random.Generator) -> Onset | None:
        """Draw the onset, if it is not set; None if it is one of the effect's tasks."""
        del rng
        return None if self.tasks else AtTime(time_s=0.0)

    def on_anatomy(self, anatomy: Anatomy) -> Anatomy:
        """Return the patient to operate on."""
        return anatomy

    def on_senses(self, model: SensorModel) -> SensorModel:
        """Return the errors of the sense `tracked`."""
        return model

    def on_picture(self, camera: str, rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the picture (height, width, 3) that a camera delivers to perception."""
        del camera
        return rgb

    def lead(self, world: World, task: Task) -> ToolAction | None:
        """Return the next motion while an arm is led astray; None while the controller acts."""
        del world, task
        return None

    def on_action(self, action: ToolAction, world: World) -> ToolAction:
        """Return the action that reaches the driver."""
        del world
        return action

    def before_step(self, world: World, task: Task) -> None:
        """Change the world before its next control step, tool exchanges included."""

    def offset_m(self, world: World) -> Array | None:
        """Return the body's displacement in the next control step.

        Returns:
            The offset (3,) from the anatomy's place of the body, m; None while the body does not
                move.
        """
        del world
        return None

    def due(self, world: World, task: Task) -> bool:
        """Return whether the perturbation begins now."""
        if self.at is None:
            needed = [k for k in self.tasks if is_needed(CHOLECYSTECTOMY.task(k), world)]
            self.at = AtTask(index=needed[int(self._share * len(needed))])
        if isinstance(self.at, AtTask):
            return task.index == self.at.index
        return world.record.time_s >= self.at.time_s - 1e-9

    def begins(self, world: World, task: Task) -> bool:
        """Return whether the perturbation begins now, for the first time; note the onset."""
        if self.applied or not self.due(world, task):
            return False
        self.note(world.record.time_s)
        return True

    def note(self, time_s: float) -> None:
        """Record the onset."""
        p = self._perturbation
        self.applied.append(Applied(name=p.name, time_s=time_s, magnitude=p.magnitude, unit=p.unit))


class Once(Effect, ABC):
    """Changes the world once, in one control step, some time after the start."""

    def drawn_onset(self, rng: np.random.Generator) -> Onset:
        return AtTime(time_s=float(rng.uniform(EARLIEST_S, LATEST_S)))

    def before_step(self, world: World, task: Task) -> None:
        if self.begins(world, task):
            self.change(world)

    @abstractmethod
    def change(self, world: World) -> None:
        """Change the world."""
