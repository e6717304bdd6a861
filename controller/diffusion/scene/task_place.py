"""Compute the place where the jaws should close for a task, and their distance from it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from controller.diffusion.scene.places import CUT, FIRST, LOWEST, SECOND, UPPER
from controller.diffusion.scene.scene import Scene
from planner.procedure.task import Task
from planner.scene.next_task import clips_needed_on, clips_on
from tissue_sim.frames import Array
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.patient.tube_names import Tube
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import RIGHT_ARM

BESIDE_M = 0.006  # of the jaws from the tube at the chunk's end; farther off it is free; assumed
WITHIN_M = 1e-4  # to either side of a place; assumed
ABOVE_LOWEST_M = 2e-4  # the upper clip at least, if it belongs higher: the cut errs, too; assumed


@dataclass(frozen=True, kw_only=True)
class TaskPlace:
    """The place at which a task's jaws should close, endoscope frame.

    Attributes:
        jaws_m: (3,) middle of the jaws.
        place_m: (3,) the place.
        lowest_m: (3,) the lowest acceptable place.
        along: (3,) unit vector up the tube at the place.
        wall_m: Distance of the place from the gallbladder's wall.
    """

    jaws_m: Array
    place_m: Array
    lowest_m: Array
    along: Array
    wall_m: float

    @property
    def off_m(self) -> Array:
        """Return the displacement (3,) from the jaws' middle to the place."""
        return self.place_m - self.jaws_m

    def lacking_m(self, moved_m: Array | float = 0.0) -> float | None:
        """Return how far the jaws are below the place along the tube.

        Args:
            moved_m: (3,) displacement of the jaws since the observation, endoscope frame.

        Returns:
            Zero within `WITHIN_M`, negative above the place; None if the jaws are beside the tube.
        """
        jaws_m, u = self.jaws_m + moved_m, self.along
        off_m = self.place_m - jaws_m
        if np.linalg.norm(off_m - (off_m @ u) * u) > BESIDE_M:
            return None
        most_m = off_m @ u + WITHIN_M
        least_m = min(most_m - 2.0 * WITHIN_M, (self.lowest_m - jaws_m) @ u + ABOVE_LOWEST_M)
        return float(np.clip(0.0, least_m, most_m))


@lru_cache(maxsize=1)  # several rules ask for the same one
def task_place(scene: Scene, task: Task) -> TaskPlace | None:
    """Return the task's place; None if the jaws have no structure left to close on."""
    observation, tube = scene.observation, task.tube
    if tube is None or not _still_close(task, tube, observation):
        return None
    tip = observation.tips_endoscope[RIGHT_ARM]
    jaws_m = tip[:3, 3] - 0.5 * observation.right_instrument.mouth_m[0] * tip[:3, 2]
    on_tube, (place, lowest) = scene.places_on(tube), _rows(task, tube, observation)
    return TaskPlace(
        jaws_m=jaws_m,
        place_m=on_tube.points_m[place],
        lowest_m=on_tube.points_m[lowest],
        along=on_tube.along[place],
        wall_m=float(on_tube.wall_m[place]),
    )


def _still_close(task: Task, tube: Tube, observation: Observation) -> bool:
    """Return whether the jaws still have to close on the task's tube."""
    if task.severs:
        return observation.right_instrument.deed == "cut" and not observation.is_severed(tube)
    return task.places_clip and observation.clip_loaded


def _rows(task: Task, tube: Tube, observation: Observation) -> tuple[int, int]:
    """Return the rows of `Places` for the task, and for the lowest acceptable place."""
    sitting = clips_on(tube, observation) + (task.clip == USUAL_CLIPS)
    n = USUAL_CLIPS if sitting >= USUAL_CLIPS else clips_needed_on(tube, observation)
    if task.severs:
        return CUT[n], CUT[n]
    if task.clip == USUAL_CLIPS:
        return UPPER[n], LOWEST[n]
    row = FIRST[n] if task.clip == 1 else SECOND
    return row, row
