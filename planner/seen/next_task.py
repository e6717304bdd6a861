"""The next task of a deed on a tube: its next clip, or its cut. From the observation alone."""

from __future__ import annotations

import numpy as np

from planner.command import Deed
from planner.seen.duct_side import structure_seen
from planner.task import TASKS, Task, Tube
from tissue_sim.frames import Array
from tissue_sim.outcome.clip_rule import USUAL_CLIPS, clips_needed
from tissue_sim.sensing.observation import MAX_CLIPS, TUBE_POINTS, Observation

ON_TUBE_M = 0.004  # from a clip's middle to the tube's centreline; assumed, about a tube's width


class NotNowError(ValueError):
    """A command cannot be carried out now; the message tells a person why."""


def next_task(deed: Deed, tube: Tube, observation: Observation) -> Task:
    """Return the task that carries out the deed.

    Args:
        deed: to clip or to cut.
        tube: on which tube.
        observation: the present one; the clips that a tube needs follow from its length there.

    Raises:
        NotNowError: the tube is cut, has all its clips, or lacks the clips that a cut needs.
    """
    n_clips = clips_on(tube, observation)
    n_needed = clips_needed(structure_seen(tube, observation), length_m(tube, observation))
    if observation.severed[("left", "right").index(tube)]:
        raise NotNowError(f"the {tube} tube is cut already")
    if deed == "clip" and n_clips >= n_needed:
        raise NotNowError(f"the {tube} tube has its {n_needed} clips")
    if deed == "cut" and n_clips < n_needed:
        raise NotNowError(f"the {tube} tube has {n_clips} of the {n_needed} clips a cut needs")
    last = USUAL_CLIPS if n_clips == n_needed - 1 else n_clips + 1  # the gallbladder's clip
    clip = last if deed == "clip" else None
    return next(t for t in TASKS if (t.kind, t.tube, t.clip) == (deed, tube, clip))


def length_m(tube: Tube, observation: Observation) -> float:
    """Return a tube's length along its observed points, m; traction makes it up to 12 % longer."""
    line = observation.left_tube_m if tube == "left" else observation.right_tube_m
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def length_std_m(tube: Tube, observation: Observation) -> float:
    """Return the standard deviation of a tube's length, m: of both ends, along it."""
    start = TUBE_POINTS * ("left", "right").index(tube)
    end = start + TUBE_POINTS - 1
    return float(np.hypot(observation.std_m[start], observation.std_m[end]))


def clips_on(tube: Tube, observation: Observation) -> int:
    """Return how many clips lie on a tube: near it, and nearer to it than to the other tube."""
    clips_m = observation.clips_m[: min(observation.n_clips, MAX_CLIPS)]
    away_m = {
        "left": distance_to_line_m(clips_m, observation.left_tube_m),
        "right": distance_to_line_m(clips_m, observation.right_tube_m),
    }
    other: Tube = "right" if tube == "left" else "left"
    return int(((away_m[tube] <= ON_TUBE_M) & (away_m[tube] < away_m[other])).sum())


def distance_to_line_m(points: Array, line: Array) -> Array:
    """Return the distances (n,) of points (n, 3) from a polyline (m, 3)."""
    start, way = line[:-1], np.diff(line, axis=0)
    along = np.einsum("nmk,mk->nm", points[:, None] - start, way)
    share = np.clip(along / np.maximum((way * way).sum(axis=1), 1e-12), 0.0, 1.0)
    nearest = start + share[..., None] * way
    return np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)
