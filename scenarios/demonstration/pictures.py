"""Frames with labels for training perception: pictures, and the places of what they show.

The expert demonstrates whole procedures, with noise, failures and corrections. Given a checkpoint,
a learned controller acts in every other episode. For patients for whom a person must be called,
only the grab is demonstrated. Short and long tubes are nearly as frequent as common ones. No
patient with a second artery is skipped, because they are few.
"""

from __future__ import annotations

import io
import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planner.learning.files import write_atomic
from scenarios.demonstration.demonstrate import (
    DemonstrationOutcome,
    begun,
    broken_off_in,
    checkpoints_of,
    trace_path,
    written,
)
from scenarios.demonstration.mix import (
    CORRECTION,
    FAILING,
    NOMINAL,
    RECOVERIES,
    RECOVERY,
    ROLLOUT,
    TRAINING_SEEDS,
    PlannedDemonstration,
)
from tissue_sim.constants import WORLD_VERSION
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.anatomy import Anatomy, anatomy_from_seed

if TYPE_CHECKING:  # heavy to import
    from tissue_sim.sensing.observation import Observation
    from tissue_sim.world import World

PICTURED = (
    NOMINAL,
    RECOVERY + FAILING,
    NOMINAL + FAILING + "swapped",
    CORRECTION,
    NOMINAL,
    NOMINAL + FAILING + "artery-in-front",
    NOMINAL + FAILING + "swapped",
    NOMINAL + FAILING + "fat",
)
# Assumed, all of them.
NEAR_M = 0.018  # from the right tip to a tube's points: there frames follow faster
NEAR_STEPS, FAR_STEPS = 8, 20  # from one frame to the next
ARTERY_M, DUCT_M = (0.016, 0.026, 0.036), (0.020,)  # between the strata of their lengths
STRATA = tuple(product(range(len(ARTERY_M) + 1), range(len(DUCT_M) + 1)))
AHEAD = 2  # a stratum with more than so many patients more than the rarest takes none
GRAB_S = 20.0  # length of the grab of a patient for whom a person must be called
DYED = 0.25  # share of patients with red liquid on the tissue
MOST_DYED = 0.3
AIM_M = 0.002  # standard deviation each way
MADE_WITH = "made_with"  # the array that records how the frames were made, as JSON


def pictured(first_seed: int, episodes: int, checkpoint: str = "") -> list[PlannedDemonstration]:
    """Plan episodes of training seeds from the first on, fewer if the training seeds end.

    A seed with frequent lengths is skipped, unless it has a second artery. A larger number of
    episodes only adds some. With a checkpoint, a learned controller acts in every other episode,
    because no expert shows its errors.
    """
    taken: list[PlannedDemonstration] = []
    counts: Counter[tuple[int, int]] = Counter({stratum: 0 for stratum in STRATA})
    for seed in range(first_seed, TRAINING_SEEDS.stop):
        if len(taken) == episodes:
            break
        anatomy = anatomy_from_seed(seed)
        stratum, rare = stratum_of(anatomy), anatomy.second_artery is not None
        if rare or counts[stratum] <= min(counts.values()) + AHEAD:
            counts[stratum] += not rare
            taken.append(_planned(seed, len(taken), checkpoint))
    return taken


def stratum_of(anatomy: Anatomy) -> tuple[int, int]:
    """Return the strata of the lengths of artery and duct."""
    artery = np.searchsorted(ARTERY_M, anatomy.artery_length_m)
    return int(artery), int(np.searchsorted(DUCT_M, anatomy.duct_length_m))


def _planned(seed: int, k: int, checkpoint: str) -> PlannedDemonstration:
    learned = bool(checkpoint) and k % 2 == 1
    kind = (ROLLOUT, ROLLOUT + FAILING)[k // 2 % 2] if learned else PICTURED[k % len(PICTURED)]
    failure = RECOVERIES[k // len(PICTURED) % len(RECOVERIES)] if kind.endswith(FAILING) else ""
    return PlannedDemonstration(
        seed=seed, kind=kind + failure, checkpoint=checkpoint if learned else ""
    )


def frames_path(demonstration: PlannedDemonstration, out: Path) -> Path:
    """Return the path of the episode's labelled frames."""
    return out / f"{demonstration.name}.npz"


def picture(demonstration: PlannedDemonstration, out: Path) -> DemonstrationOutcome:
    """Run the episode and write its labelled frames; an exception in it becomes its error."""
    try:
        frames = list(_frames(demonstration))
        made = {"world_version": WORLD_VERSION, "checkpoints": checkpoints_of(demonstration)}
    except Exception as error:
        return broken_off_in(out, demonstration, error)
    content = io.BytesIO()
    columns: dict[str, Any] = {name: np.array([f[name] for f in frames]) for name in frames[0]}
    columns[MADE_WITH] = np.array(json.dumps(made))
    np.savez_compressed(content, **columns)
    path = frames_path(demonstration, out)
    return written(
        DemonstrationOutcome(demonstration=demonstration, frames=len(frames)),
        path,
        partial(write_atomic, path, content.getvalue()),
        partial(trace_path(demonstration, out).unlink, missing_ok=True),
    )


def _frames(demonstration: PlannedDemonstration) -> Iterator[dict[str, Any]]:
    from planner.instruction import Instruction
    from planner.procedure.cholecystectomy import GRAB
    from scenarios.demonstration.interjections import PlannerFixed
    from tissue_sim.sensing.observation import tip_to_tubes_m

    episode = begun(demonstration, render=True)
    world, rng = episode.world, np.random.default_rng([0x1CE, demonstration.seed])
    if rng.random() < DYED:
        world.conditions = replace(world.conditions, dyed=rng.uniform(0.0, MOST_DYED))
    grabs_only = why_call(world.anatomy) is not None
    if grabs_only:
        episode.planner = PlannerFixed(instruction=Instruction(task=GRAB))
    wait = 0
    for step in episode.steps():
        wait -= 1
        if wait <= 0:
            yield labelled_frame(world, step.exact, rng)
            wait = NEAR_STEPS if tip_to_tubes_m(step.exact) < NEAR_M else FAR_STEPS
        if grabs_only and step.time_s > GRAB_S:
            return


def labelled_frame(world: World, exact: Observation, rng: np.random.Generator) -> dict[str, Any]:
    """Return pictures of all views and their labels, by name.

    The endoscope's crop is off the tubes by about the error of perception's estimate.
    """
    from tissue_sim.frames import transform
    from tissue_sim.patient.tube_names import USUAL_TUBES
    from tissue_sim.rendering.shader_pack import COLOR_PICTURE, POSITION_PICTURE
    from tissue_sim.sensing.cameras import T_world_camera
    from tissue_sim.sensing.eyes import CLOSE, VIEWS
    from tissue_sim.sensing.observation import TUBE_POINTS
    from tissue_sim.sensing.picture_points import project, shown_points, visible

    assert world.view is not None, "a labelled frame needs a world with cameras"
    middle_m = exact.tubes_m[: len(USUAL_TUBES)].mean(axis=(0, 1))
    aimed_m = middle_m + AIM_M * rng.standard_normal(3)
    aims_m = {CLOSE: transform(world.T_world_endoscope, aimed_m)}
    taken = world.view.pictures(world, VIEWS, (COLOR_PICTURE, POSITION_PICTURE), aims_m)
    points, there, depths = shown_points(world, exact)
    wide_m = np.concatenate([np.repeat(exact.tube_radius_m, TUBE_POINTS), exact.sac_radius_m])
    frame: dict[str, Any] = {
        "points_m": exact.points_m().astype(np.float32),
        "there": there,
        "severed": exact.severed,
        "tips": exact.tips_endoscope.astype(np.float32),
        "radius_m": exact.tube_radius_m.astype(np.float32),
        "sac_radius_m": exact.sac_radius_m.astype(np.float32),
        "third_tube": exact.third_tube,
    }
    for spec in VIEWS:
        T_world_eye = T_world_camera(world, spec.name, aims_m.get(spec.name))
        pixels, ahead = project(spec, T_world_eye, points)
        shown = there & visible(pixels, ahead, depths, taken[POSITION_PICTURE][spec.name])
        frame[f"rgb.{spec.name}"] = taken[COLOR_PICTURE][spec.name]
        frame[f"pixels.{spec.name}"] = np.where(ahead[:, None] > 0.002, pixels, -1e4).astype(
            np.float32
        )
        frame[f"visible.{spec.name}"] = shown
        frame[f"radius.{spec.name}"] = (
            spec.focal_px * wide_m / ahead[: len(wide_m)].clip(0.002)
        ).astype(np.float32)
    return frame
