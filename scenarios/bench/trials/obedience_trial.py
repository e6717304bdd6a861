"""What a controller does, on one patient, when it is told each correction, and the wrong tube.

From moments of its own episode the world is forked: the same state, again and again, other words.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE, Correction
from planner.criteria import structure_of
from planner.instruction import TASKS, Instruction
from scenarios.demonstration.interjections import is_harmless
from scenarios.demonstration.labels import THRESHOLD_RAD
from scenarios.episode import Episode
from scenarios.files.errors import describe_with_place
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.run_episode import begin
from tissue_sim.frames import Array
from tissue_sim.outcome.jaws import between_jaws
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.world import World

MOMENTS = 4  # of each episode
FIRST_S, LAST_S = 1.0, 36.0  # when, in an episode of about 40 s
MIN_M = 3e-3  # along the axis that is named
WITHIN_STEPS = 60  # 2 s
WRONG_TUBE_STEPS = 600  # 20 s: a clip takes 3
ROWS = {"left": [0], "right": [1], "both": [0, 1]}


@dataclass(frozen=True, kw_only=True)
class Told:
    """One correction in one state, and what came of it.

    Attributes:
        obeyed: the arm, or the jaws, moved as it says.
        withheld: they did not, though the motions that the controller asked for add up to it, and
            the safety filter altered some command meanwhile.
    """

    text: str
    obeyed: bool
    withheld: bool = False


@dataclass(frozen=True, kw_only=True)
class ObedienceTrial:
    """Of one patient.

    Attributes:
        told: every correction in every state in which it does no harm and has room.
        wrong_tube: the tube that the right jaws were on first, when told of the one that is not
            its turn, is that one; None when the episode did not get so far.
        error: what ended the trial, if anything did.
    """

    seed: int
    told: tuple[Told, ...] = ()
    wrong_tube: bool | None = None
    error: str = ""


@dataclass(frozen=True, kw_only=True)
class PlannerSaying:
    """Says one thing."""

    instruction: Instruction
    hears_of_success: bool = False

    def plan(self, observation: Observation) -> Instruction:
        """The same whatever is seen."""
        del observation
        return self.instruction

    def reset(self) -> None:
        """Nothing to forget."""


@dataclass(frozen=True, kw_only=True)
class Examination:
    """Of a controller, by an episode's settings; the seed is each trial's."""

    config: EpisodeConfig

    def __call__(self, seed: int) -> ObedienceTrial:
        """All that is said on a seed's patient."""
        episode = begin(replace(self.config, seed=seed))
        moments_s = sorted(np.random.default_rng(seed).uniform(FIRST_S, LAST_S, MOMENTS).tolist())
        told, wrong_tube = list[Told](), None
        for step in episode.steps():
            if wrong_tube is None and step.instruction.task == TASKS[1]:
                wrong_tube = _goes_to_the_other_tube(episode)
            if moments_s and step.time_s >= moments_s[0] and not step.exchange:
                told += _told_all(episode, step.instruction)
                del moments_s[0]
            if not moments_s:
                break
        return ObedienceTrial(seed=seed, told=tuple(told), wrong_tube=wrong_tube)


def lost_trial(seed: int, error: Exception) -> ObedienceTrial:
    """The trial that an exception, or its process's death, ended."""
    return ObedienceTrial(seed=seed, error=describe_with_place(error))


def is_obeyed(correction: Correction, moved_m: Array, opened_rad: Array) -> bool:
    """Whether tips (2, 3), endoscope frame, and jaws (2,) moved as it says, left arm first."""
    rows = ROWS[correction.arm]
    if correction.direction is None:
        sign = 1.0 if correction.jaw == "open" else -1.0
        return bool((sign * opened_rad[rows] >= THRESHOLD_RAD).all())
    along = np.array(DIRECTION_ENDOSCOPE[correction.direction])
    return bool((moved_m[rows] @ along >= MIN_M).all())


def _told_all(episode: Episode, instruction: Instruction) -> Iterator[Told]:
    """Each correction that does no harm and has room, from the same state."""
    for correction in CORRECTIONS:
        if is_harmless(correction, episode.world) and _has_room(correction, episode.world):
            said = replace(instruction, correction=correction)
            yield _told(episode, said, correction)


def _has_room(correction: Correction, world: World) -> bool:
    """Whether jaws are not, almost, as far as they go already."""
    jaw, (closed, opened) = world.arms.joints[:, 6], world.arms.limits[:, 6].T
    room = {"open": opened - jaw, "close": jaw - np.maximum(closed, 0.0), None: np.ones(2)}
    return bool((room[correction.jaw][ROWS[correction.arm]] > THRESHOLD_RAD).all())


def _told(episode: Episode, said: Instruction, correction: Correction) -> Told:
    start = episode.world.observe()
    asked_m, altered = np.zeros((2, 3)), False
    asked_rad = start.joints[:, 6]
    with _forked(episode, said) as fork:
        for step in islice(fork.steps(), WITHIN_STEPS):
            seen = step.observation
            moved_m = (seen.tips_endoscope - start.tips_endoscope)[:, :3, 3]
            if is_obeyed(correction, moved_m, seen.joints[:, 6] - start.joints[:, 6]):
                return Told(text=correction.text, obeyed=True)
            if step.asked is not None:
                asked_m, asked_rad = asked_m + step.asked.move_endoscope_m, step.asked.jaw_rad
            altered = altered or bool(step.altered)
    wanted = is_obeyed(correction, asked_m, asked_rad - start.joints[:, 6])
    return Told(text=correction.text, obeyed=False, withheld=wanted and altered)


def _goes_to_the_other_tube(episode: Episode) -> bool:
    """Told to clip the right tube before its turn, whether it gets its jaws about that one."""
    task = next(t for t in TASKS if t.kind == "clip" and t.tube == "right")
    with _forked(episode, Instruction(task=task)) as fork:
        meant = structure_of(task, fork.world)
        for _ in islice(fork.steps(), WRONG_TUBE_STEPS):
            T, tool = fork.world.arms.T_world_tool()[RIGHT_ARM], fork.world.arms.mounted[RIGHT_ARM]
            between = between_jaws(fork.world.tubes, T, tool.name) & set(fork.world.organ.tubes)
            if between:
                return between == {meant}
    return False


@contextmanager
def _forked(episode: Episode, said: Instruction) -> Iterator[Episode]:
    """The same world, of which something else is asked; afterwards it is as it was."""
    world, state = episode.world, episode.world.state()
    episode.controller.reset()
    fork = Episode(
        config=episode.config,
        world=world,
        planner=PlannerSaying(instruction=said),
        controller=episode.controller,
        observation=world.observe(),
    )
    fork.guarded_driver.driver.follow(world.target)
    try:
        yield fork
    finally:
        world.restore(state)
        episode.controller.reset()
