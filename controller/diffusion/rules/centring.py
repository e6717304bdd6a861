"""A chunk that brings the jaws onto a tube closes them where clip or cut belongs along it.

A policy errs along the tube by some tenths of a millimetre, and a short artery has no more room
than that. Where clips and cut belong is a rule on what is seen (`places`), so the rule has the last
word in this one direction; all else is the policy's.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from controller.diffusion.chunk_frame import JAW, MOVE
from controller.diffusion.seen.gallbladder import wall_distance_m
from controller.diffusion.seen.places import CUT, FIRST, LOWEST, SECOND, UPPER, places_on
from planner.command import TUBES
from planner.seen.next_task import clips_needed_on, clips_on
from planner.task import Task, Tube
from tissue_sim.frames import Array
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.sensing.observation import (
    CLIP_APPLIER,
    SCISSORS,
    Observation,
    fields,
    observation_of,
)
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.blade_size import BLADE_LENGTH_M
from tissue_sim.tools.clip_size import CLIP_LENGTH_M

BESIDE_M = 0.006  # of the jaws from the tube at the chunk's end; farther off it is free; assumed
WITHIN_M = 1e-4  # to either side of a place; assumed
ABOVE_LOWEST_M = 2e-4  # the upper clip at least, if it belongs higher: the cut errs, too; assumed
ACTED_RAD = 0.12  # jaws that have closed on a clip have 0.07, blades that have cut 0.12
SOONEST = 8  # rows in which a chunk is moved by all that it lacks, at least; assumed
MOST_M = 1e-3  # by which a chunk's end is moved at most; assumed
REACH_M = {CLIP_APPLIER: CLIP_LENGTH_M, SCISSORS: BLADE_LENGTH_M}


def centred(chunk: Array, seen: NDArray[np.float32], task: Task) -> Array:
    """Return a chunk (n, 20) that closes, or ends, within the task's places along its tube.

    It is returned as it is where the jaws end beside the tube, or have nothing left to close on.

    Args:
        chunk: as `chunk_frame` has it; not changed.
        seen: `Observation.vector()` at its start.
        task: the running one.
    """
    arms = chunk.reshape(len(chunk), 2, -1).copy()
    row = _closing_row(arms[:, RIGHT_ARM, JAW])
    lacking = lacking_m(seen, task, moved_m=arms[row, RIGHT_ARM, MOVE])
    if lacking is None:
        return chunk
    along_m, along = lacking
    share = np.minimum(np.arange(1, len(arms) + 1) / max(row + 1, SOONEST), 1.0)
    arms[:, RIGHT_ARM, MOVE] += share[:, None] * np.clip(along_m, -MOST_M, MOST_M) * along
    return arms.reshape(chunk.shape)


def _closing_row(jaws_rad: Array) -> int:
    """Return the row in which jaws (n,) close, as a policy goes back after it, or the last one."""
    closed = np.flatnonzero(jaws_rad < ACTED_RAD)
    return int(closed[0]) if len(closed) else len(jaws_rad) - 1


def lacking_m(
    seen: NDArray[np.float32], task: Task, moved_m: Array | float = 0.0
) -> tuple[float, Array] | None:
    """Return how far the jaws are below the task's places, and which way (3,) is up the tube.

    Args:
        seen: `Observation.vector()`.
        task: the running one.
        moved_m: what the jaws will have moved by (3,), endoscope frame.

    Returns:
        Zero within the places, negative above them. None if the jaws are beside the tube, or have
        nothing left to close on.
    """
    upon = _upon(seen, task, moved_m)
    if upon is None:
        return None
    off_m, u = upon.off_m[upon.place], upon.along
    if np.linalg.norm(off_m - (off_m @ u) * u) > BESIDE_M:
        return None
    most_m = off_m @ u + WITHIN_M
    least_m = min(most_m - 2.0 * WITHIN_M, upon.off_m[upon.lowest] @ u + ABOVE_LOWEST_M)
    return float(np.clip(0.0, least_m, most_m)), u


def place_ahead(seen: NDArray[np.float32], task: Task) -> tuple[Array, float] | None:
    """Return the way (3,) from the jaws' middle to the task's place, and its room.

    The room is the distance of the place from the gallbladder's wall. None if the jaws have nothing
    left to close on.
    """
    upon = _upon(seen, task, 0.0)
    return None if upon is None else (upon.off_m[upon.place], float(upon.room_m[upon.place]))


class _Upon(NamedTuple):
    """The places on the task's tube, and which two are the task's.

    Attributes:
        off_m: (9, 3) from the jaws' middle to the places, endoscope frame.
        room_m: (9,) of the places from the gallbladder's wall.
        along: (3,) up the tube at the task's place.
        place, lowest: rows of the task's place, and of the lowest that will do.
    """

    off_m: Array
    room_m: Array
    along: Array
    place: int
    lowest: int


def _upon(seen: NDArray[np.float32], task: Task, moved_m: Array | float) -> _Upon | None:
    observation, tube = observation_of(seen, 0.0), task.tube
    if tube is None or not _still_close(task, tube, observation):
        return None
    tip = observation.tips_endoscope[RIGHT_ARM]
    jaws_m = tip[:3, 3] - 0.5 * REACH_M[observation.tools[1]] * tip[:3, 2] + moved_m
    now = {name: torch.from_numpy(part[None].copy()) for name, part in fields(seen).items()}
    on_tube = places_on(now)[TUBES.index(tube)]
    room_m = wall_distance_m(now["sac_m"], now["sac_radius_m"], on_tube.points_m)
    points, along, room_m = (
        part[0].numpy().astype(float) for part in (on_tube.points_m, on_tube.along, room_m)
    )
    place, lowest = _rows(task, tube, observation)
    return _Upon(points - jaws_m, room_m, along[place], place, lowest)


def _still_close(task: Task, tube: Tube, observation: Observation) -> bool:
    """Return whether the jaws still have to close on the task's tube."""
    if task.kind == "cut":
        return observation.tools[1] == SCISSORS and not observation.severed[TUBES.index(tube)]
    return task.kind == "clip" and observation.clip_loaded


def _rows(task: Task, tube: Tube, observation: Observation) -> tuple[int, int]:
    """Return the rows of `Places` for the task, and for the lowest place that will do."""
    sitting = clips_on(tube, observation) + (task.clip == USUAL_CLIPS)
    n = USUAL_CLIPS if sitting >= USUAL_CLIPS else clips_needed_on(tube, observation)
    if task.kind == "cut":
        return CUT[n], CUT[n]
    if task.clip == USUAL_CLIPS:
        return UPPER[n], LOWEST[n]
    row = FIRST[n] if task.clip == 1 else SECOND
    return row, row
