"""Run one demonstration, from its seed to its file."""

from __future__ import annotations

import os
import time
import traceback
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planner.learning.files import write_atomic
from scenarios.catalogue import ORACLE
from scenarios.demonstration.mix import (
    CORRECTION,
    DECLINED,
    FORKED,
    IN_TURNS,
    OF_THE_LEARNED,
    ORDER,
    TURNS,
    PlannedDemonstration,
)
from scenarios.files.errors import describe_error
from scenarios.loop.results import EpisodeResult
from scenarios.workers.process import importing, saving

if TYPE_CHECKING:  # heavy to import
    from numpy.random import Generator

    from controller.base import Controller
    from controller.dataset.dataset_episode import DatasetEpisode as Demonstrated
    from planner.base import Planner
    from scenarios.episode import Episode as Running
    from scenarios.loop.episode_config import EpisodeConfig
    from tissue_sim.sensing.observation import Observation
    from tissue_sim.world import World

PARTS, FAILED, ERRORS = "parts", "failed", "errors"


@dataclass(frozen=True, kw_only=True)
class DemonstrationOutcome:
    """Result of a demonstration.

    Attributes:
        success: Whether the procedure succeeded, or the patient was declined as planned. Of failed
            ones only those enter the dataset in which a learned controller acted.
        error: The error that broke the episode off; None for none.
        unwritable: The reason why the file could not be written; None if it was written.
    """

    demonstration: PlannedDemonstration
    success: bool = False
    error: str | None = None
    unwritable: str | None = None
    frames: int = 0
    wall_s: float = 0.0


def part_path(demonstration: PlannedDemonstration, out: Path, folder: str = PARTS) -> Path:
    """Return the path of the demonstration's frames."""
    return out / folder / f"{demonstration.name}.parquet"


def trace_path(demonstration: PlannedDemonstration, out: Path) -> Path:
    """Return the path of the traceback of a demonstration that broke off."""
    return out / ERRORS / f"{demonstration.name}.txt"


def is_finished(demonstration: PlannedDemonstration, out: Path) -> bool:
    """Return whether the file exists, passed or failed; an interrupted demonstration has none."""
    return any(part_path(demonstration, out, f).exists() for f in (PARTS, FAILED))


def demonstrate(demonstration: PlannedDemonstration, out: Path) -> DemonstrationOutcome:
    """Run a demonstration and write its file to `out`; an exception in it becomes its error."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # small tensors: more threads are slower
    with importing():
        import scenarios.run_episode  # noqa: F401  # with all imports of an episode
        from controller.dataset.part import part_bytes

    start_s, part = time.perf_counter(), part_path(demonstration, out)
    try:
        episode = run(demonstration, part)
        content = part_bytes(episode)
    except Exception as error:
        return broken_off_in(out, demonstration, error)
    success = episode.header.success
    outcome = DemonstrationOutcome(
        demonstration=demonstration,
        success=success,
        frames=len(episode),
        wall_s=time.perf_counter() - start_s,
    )
    joins = success or demonstration.family in OF_THE_LEARNED
    path = part if joins else part_path(demonstration, out, FAILED)
    return written(
        outcome,
        path,
        partial(_move_videos, demonstration, part, path),
        partial(write_atomic, path, content),
        partial(trace_path(demonstration, out).unlink, missing_ok=True),
    )


def _move_videos(demonstration: PlannedDemonstration, part: Path, path: Path) -> None:
    """Move the videos from beside `part` to the folder of its frames."""
    from controller.dataset.part import video_path

    path.parent.mkdir(parents=True, exist_ok=True)
    for camera in demonstration.cameras:
        video_path(part, camera).replace(video_path(path, camera))


def run(demonstration: PlannedDemonstration, part: Path) -> Demonstrated:
    """Run the demonstration, and film it into files beside `part`; return its frames."""
    import numpy as np

    from controller.dataset.dataset_episode import DatasetEpisode, Header
    from scenarios.demonstration.demonstration_recorder import DemonstrationRecorder
    from scenarios.demonstration.filming import Filming
    from scenarios.demonstration.forks import Forks
    from scenarios.demonstration.rollout_recorder import RolloutRecorder
    from scenarios.demonstration.turns import expert_acts
    from scenarios.files.strict_json import plain
    from scenarios.files.versions import versions
    from scenarios.run_episode import play

    seed, kind, cameras = demonstration.seed, demonstration.kind, demonstration.cameras
    episode = begun(demonstration, render=bool(cameras))
    forks = Forks(episode, np.random.default_rng([0xF0C5, seed]))
    make = RolloutRecorder if demonstration.is_rollout else DemonstrationRecorder
    recorder = make(lambda: expert_acts(episode.controller), filmed=bool(cameras))
    with ExitStack() as filmed:
        filming = [filmed.enter_context(Filming(cameras, part))] if cameras else []
        forking = [forks] if demonstration.family in FORKED else []
        result = play(episode, [recorder, *forking, *filming], time.perf_counter())
    header = Header(
        seed=seed,
        kind=kind,
        scenario=demonstration.scenario,
        success=result.success or _is_declined(demonstration, result),
        failures=failures_of(result),
        anatomy=plain(episode.world.anatomy),
        versions=versions(),
        cameras=cameras,
        sense=demonstration.sense,
        checkpoints=checkpoints_of(demonstration),
    )
    columns = forks.joined(recorder.columns(seed, kind), seed, kind)
    return DatasetEpisode(header=header, columns=columns)


def begun(demonstration: PlannedDemonstration, *, render: bool = False) -> Running:
    """Return the episode of a demonstration, with its planned failures arranged."""
    import numpy as np

    from scenarios.demonstration.failures import failures
    from scenarios.demonstration.noise import NOISE
    from scenarios.episode import Episode
    from scenarios.loop.episode_config import EpisodeConfig
    from scenarios.loop.senses import make_sense
    from scenarios.perturbation.effects import Effects
    from scenarios.run_episode import anatomy_of, patient_on_table

    seed, scenario = demonstration.seed, demonstration.scenario
    rng = np.random.default_rng([0xDE30, seed])
    noise = (NOISE,) if demonstration.noise and not demonstration.is_rollout else ()
    config = EpisodeConfig(seed=seed, scenario=scenario, **_choices(demonstration))
    effects = Effects((*failures(scenario, anatomy_of(config), rng), *noise), seed)
    world = patient_on_table(config, effects, render=render)
    sense = make_sense(config, effects)
    return Episode(
        config=config,
        world=world,
        sense=sense,
        observation=sense.observe(world, world.observe()),
        effects=effects,
        planner=_planner(demonstration, config, world, rng),
        controller=_controller(demonstration, config, world, rng),
    )


def checkpoints_of(demonstration: PlannedDemonstration) -> dict[str, str]:
    """Return the SHA-256 of the checkpoint of each learned policy in it, by role.

    Raises:
        CheckpointError, OSError: As `checkpoint_digests`.
    """
    from scenarios.loop.episode_config import EpisodeConfig, checkpoint_digests

    if demonstration.family not in OF_THE_LEARNED:
        return {}
    config = EpisodeConfig(**_choices(demonstration))
    learner = replace(config, controller="diffusion", checkpoint=demonstration.checkpoint)
    return checkpoint_digests(learner)


def _choices(demonstration: PlannedDemonstration) -> dict[str, Any]:
    """Return planner, controller and sense, as `EpisodeConfig` takes them."""
    chosen = ORACLE | {"sense": demonstration.sense}
    if demonstration.is_rollout:
        chosen |= {"controller": "diffusion", "checkpoint": demonstration.checkpoint}
    if demonstration.is_rollout and demonstration.planner:
        chosen |= {"planner": "learned", "planner_checkpoint": demonstration.planner}
    return chosen


def _planner(
    demonstration: PlannedDemonstration, config: EpisodeConfig, world: World, rng: Generator
) -> Planner[Observation]:
    """Return the planner; a learned controller gets the next task no sooner than in a run.

    In every other noisy demonstration the expert gets the next task no sooner either. The
    retraction then does not end at its earliest possible end. Otherwise a policy with an uncertain
    observation would stop just there.
    """
    from planner.scripted import PlannerScripted
    from scenarios.demonstration.interjections import PlannerInterjecting
    from scenarios.demonstration.mix import shuffled_order
    from scenarios.loop.policies import make_planner

    if demonstration.planner:
        planner = make_planner(config, world)
    else:
        late = demonstration.noise and demonstration.seed % 2 == 1
        prompt = demonstration.family not in OF_THE_LEARNED and not late
        order = shuffled_order(rng) if demonstration.family in (ORDER, *IN_TURNS, *FORKED) else ()
        planner = PlannerScripted(
            world,
            order=order,
            hears_of_success=prompt,
            grabs_before_calling=demonstration.family == DECLINED,
        )
    corrected_by_turns = demonstration.family == TURNS and demonstration.seed % 2 == 1
    if demonstration.family == CORRECTION or corrected_by_turns:
        return PlannerInterjecting(planner, world, rng)
    return planner


def _controller(
    demonstration: PlannedDemonstration, config: EpisodeConfig, world: World, rng: Generator
) -> Controller:
    from scenarios.demonstration.turns import ControllerTakingTurns
    from scenarios.loop.policies import make_controller

    controller = make_controller(config, world)
    if demonstration.family not in IN_TURNS:
        return controller
    from controller.diffusion.controller import load_controller

    learner = load_controller(demonstration.checkpoint, demonstration.seed)
    return ControllerTakingTurns(learner, controller, rng)


def _is_declined(demonstration: PlannedDemonstration, result: EpisodeResult) -> bool:
    """Return whether a patient who must be declined was: the grab alone was to be shown."""
    return demonstration.family == DECLINED and result.outcome == "called"


def failures_of(result: EpisodeResult) -> list[str]:
    """Return the reasons of failure: injuries, and tasks that were not done."""
    injuries = [f"{i.event} at {i.time_s:.1f} s" for i in result.injuries]
    return injuries + [f"not done: {t.instruction}" for t in result.tasks if not t.is_over]


def written(
    outcome: DemonstrationOutcome, path: Path, *writes: Callable[[], object]
) -> DemonstrationOutcome:
    """Write a demonstration's file `path`; return its outcome, which names failures."""
    try:
        with saving():
            for write in writes:
                write()
    except OSError as error:
        return DemonstrationOutcome(
            demonstration=outcome.demonstration, unwritable=f"{path}: {error.strerror}"
        )
    return outcome


def broken_off(demonstration: PlannedDemonstration, error: Exception) -> DemonstrationOutcome:
    """Return the outcome of a demonstration that `error` ended."""
    return DemonstrationOutcome(demonstration=demonstration, error=describe_error(error))


def broken_off_in(
    out: Path, demonstration: PlannedDemonstration, error: Exception
) -> DemonstrationOutcome:
    """Return the outcome of a demonstration that `error` ended; write its traceback to `out`."""
    path, trace = trace_path(demonstration, out), "".join(traceback.format_exception(error))
    return written(
        broken_off(demonstration, error), path, partial(write_atomic, path, trace.encode())
    )
