"""Report whether the interlocks would allow a clip or a cut of a tube now, by observation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from planner.person.findings import Asked
from planner.person.premises import clips_in_words
from planner.scene.duct_side import structure_seen
from planner.scene.in_words import all_tubes
from planner.scene.next_task import applier_on, clips_needed_on, clips_on, lying_on, next_of_all
from planner.scene.predicates import has_slipped
from tissue_sim.frames import Array
from tissue_sim.patient.tube_names import Tube
from tissue_sim.sensing.observation import MAX_CLIPS, TUBE_POINTS, Observation
from tissue_sim.sensing.polyline import nearest_on
from tissue_sim.thresholds import CUFF_MIN_M
from tissue_sim.tools.instruments import clip_of


def safe(asked: Asked) -> str:
    """Return in words the obstacles to cutting and clipping a tube, or that there are none."""
    tube, observation = (
        asked.tube or asked.instruction.task.tube or _next_tube(asked.observation),
        asked.observation,
    )
    if tube is None:
        return f"{all_tubes(observation).capitalize()} are cut already."
    name = structure_seen(tube, observation)
    if observation.is_severed(tube):
        return f"The {name} is cut already."
    forbidden = asked.instruction.forbidden
    against = [*_against_cut(tube, observation), *_against(name, "cut", forbidden, observation)]
    if not against:
        return f"Nothing that I see stands against cutting the {name}: {_room(tube, observation)}."
    told = f"To cut the {name} is not safe: {'; '.join(against)}."
    if clips_on(tube, observation) >= clips_needed_on(tube, observation):
        return told
    against = [*_against(name, "clip", forbidden, observation)]
    if against:
        return f"{told} Nor is it to clip it: {'; '.join(against)}."
    return f"{told} Nothing that I see stands against clipping it."


def _against_cut(tube: Tube, observation: Observation) -> Iterator[str]:
    n, needed = clips_on(tube, observation), clips_needed_on(tube, observation)
    if n < needed:
        yield (
            clips_in_words(tube, observation)
            if n
            else f"it needs {needed} clips, and no clip is on it"
        )
    elif gap_m(tube, observation) < cut_gap_m(tube, observation):
        yield f"only {_room(tube, observation)}"


def _against(
    name: str, act: str, forbidden: tuple[str, ...], observation: Observation
) -> Iterator[str]:
    if {act, f"{act} {name}"} & set(forbidden):
        yield "you forbade it"
    if has_slipped(observation):
        yield "the grasper does not hold the gallbladder"


def gap_m(tube: Tube, observation: Observation) -> float:
    """Return the distance between the middles of the clips beside the cut, along a tube at rest.

    These clips are the highest and the next lower one.
    """
    low, high = np.sort(_places(tube, observation))[-2:]
    return float(high - low) * observation.length_m(tube)


def cut_gap_m(tube: Tube, observation: Observation) -> float:
    """Return the least distance between the middles of the clips beside a cut of a tube."""
    return clip_of(applier_on(tube, observation)).width_m + 2.0 * CUFF_MIN_M


def _room(tube: Tube, observation: Observation) -> str:
    apart_mm = 1e3 * gap_m(tube, observation)
    return (
        f"{clips_in_words(tube, observation)}, and {apart_mm:.1f} mm apart beside the cut,"
        f" which needs {1e3 * cut_gap_m(tube, observation):.1f} mm with its cuffs"
    )


def _places(tube: Tube, observation: Observation) -> Array:
    """Return the places (n,) of the clips on a tube, as shares of its length from below."""
    line = observation.tube_m(tube)
    clips_m = observation.clips_m[: min(observation.n_clips, MAX_CLIPS)][
        lying_on(tube, observation)
    ]
    places = (nearest_on(line, clip_m) for clip_m in clips_m)
    return np.array([(k + share) / (TUBE_POINTS - 1) for k, share, _ in places])


def _next_tube(observation: Observation) -> Tube | None:
    task = next_of_all(observation)
    return task and task.tube
