"""An instrument loses its clip, or its hold on tissue."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from planner.procedure.cholecystectomy import TASKS
from planner.procedure.task import Task
from scenarios.perturbation.effect import Effect, Once
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.outcome.predicates import right_arm_back

if TYPE_CHECKING:
    from tissue_sim.world import World

CLIP_TASKS = tuple(task.index for task in TASKS if task.places_clip)
GRASP_SLIPS_S = 3.0  # assumed: time enough for the pull of the tissue to draw it out


class ClipDropped(Effect):
    """The applier loses its clip near the tube, `magnitude` times in one task."""

    tasks = CLIP_TASKS

    def before_step(self, world: World, task: Task) -> None:
        left = len(self.applied) < self.magnitude and self.due(world, task)
        if left and world.record.clip_loaded and not right_arm_back(world):
            self.note(world.record.time_s)
            world.drop_clip()


class GraspSlip(Effect):
    """The grasper's jaws lose a share `magnitude` of their friction for a while.

    Before and after this time, other perturbations may set the friction: an episode may have
    several slips.
    """

    tasks = CLIP_TASKS

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        super().__init__(perturbation, rng)
        self._is_over = False

    def before_step(self, world: World, task: Task) -> None:
        self.begins(world, task)
        if self.applied and not self._is_over:
            self._is_over = world.record.time_s - self.applied[0].time_s >= GRASP_SLIPS_S
            grip = 1.0 if self._is_over else 1.0 - self.magnitude
            world.conditions = replace(world.conditions, grip=grip)


class Drop(Once):
    """The applier loses its clip at once, if it holds one."""

    def change(self, world: World) -> None:
        world.drop_clip()
