"""Check whether one patient's controller obeys each correction, and the order of the wrong tube.

The controller alone carries out a planner's correction; a person's correction is carried out by
rule. All corrections at one time of an episode start from the same saved state. From there the
controller also goes on without a correction, and under a planner's corrections with a distance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass, replace
from itertools import islice
from typing import Literal

import numpy as np
from rich.table import Table

from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE, Correction
from planner.correction_way import moved_m
from planner.instruction import Instruction
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.outcomes import structure_of
from scenarios.bench.trials.distance_trial import WITHIN_M, WITHIN_SHARE
from scenarios.bench.trials.run_trials import Trial
from scenarios.demonstration.interjections import PlannerFixed, harmless_m, is_harmless
from scenarios.demonstration.labels import THRESHOLD_RAD
from scenarios.episode import Episode
from scenarios.files.outside_text import table_of
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import wilson_interval
from scenarios.run_episode import begin
from tissue_sim.frames import Array
from tissue_sim.patient.tubes import between_jaws
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.world import World

Speaker = Literal["planner", "person"]
FIRST_CLIP = CHOLECYSTECTOMY.of("clip", "left", 1)
OTHER_CLIP = CHOLECYSTECTOMY.of("clip", "right", 1)
MOMENTS = 4  # of each episode
FIRST_S, LAST_S = 1.0, 36.0  # range of their times; an episode lasts about 40 s
MIN_M = 3e-3  # motion in the named direction that counts as obeyed
WITHIN_STEPS = 60  # 2 s
DISTANCE_STEPS = 150  # 5 s: the arms go 3 to 12 mm/s, at most 20 mm
WRONG_TUBE_STEPS = 600  # 20 s: a clip takes 3


@dataclass(frozen=True, kw_only=True)
class CorrectionResponse:
    """One correction in one state, and the controller's response.

    Attributes:
        obeyed: The arm or the jaws moved as the correction says.
        by_chance: They did so without the correction.
        withheld: The arm or the jaws did not move as the correction says, although the controller's
            actions add up to that motion. The safety filter changed some command meanwhile.
        told_m, gone_m: A distance that was told with the correction in another fork, and how far
            the arm went. None if none was told.
    """

    text: str
    obeyed: bool
    by_chance: bool = False
    withheld: bool = False
    told_m: float | None = None
    gone_m: float = 0.0

    @property
    def right_distance(self) -> bool:
        """Return whether the arm went the told distance, but for an error that is allowed."""
        assert self.told_m is not None, "a distance was told"
        return abs(self.gone_m - self.told_m) <= max(WITHIN_M, WITHIN_SHARE * self.told_m)


@dataclass(frozen=True, kw_only=True)
class ObedienceTrial(Trial):
    """Result for one patient.

    Attributes:
        responses: To each correction, in each state in which it is harmless and the jaws can move.
        wrong_tube: Whether the right jaws first reach the instructed tube, although its turn has
            not come. None if the first clip's turn had not come when the episode ended, or if all
            `MOMENTS` of its corrections had passed.
    """

    responses: tuple[CorrectionResponse, ...] = ()
    wrong_tube: bool | None = None


def examine_obedience(seed: int, config: EpisodeConfig, by: Speaker = "planner") -> ObedienceTrial:
    """Run the trial on a seed's patient, under an episode's configuration.

    Args:
        seed: Seed of the patient.
        config: The episode, but for its seed.
        by: Speaker of the corrections: the planner or a person.
    """
    episode = begin(replace(config, seed=seed))
    rng = np.random.default_rng(seed)
    moments_s = sorted(rng.uniform(FIRST_S, LAST_S, MOMENTS).tolist())
    responses, wrong_tube = list[CorrectionResponse](), None
    for step in episode.steps():
        if wrong_tube is None and step.instruction.task == FIRST_CLIP:
            wrong_tube = _goes_to_the_other_tube(episode)
        if moments_s and step.time_s >= moments_s[0] and not step.exchange:
            responses += _responses(episode, step.instruction, by, rng)
            del moments_s[0]
        if not moments_s:
            break
    return ObedienceTrial(seed=seed, responses=tuple(responses), wrong_tube=wrong_tube)


def is_obeyed(correction: Correction, moved_m: Array, opened_rad: Array) -> bool:
    """Return whether tips (2, 3), endoscope frame, and jaws (2,) moved as the correction says."""
    rows = correction.rows
    if correction.direction is None:
        sign = 1.0 if correction.jaw == "open" else -1.0
        return bool((sign * opened_rad[rows] >= THRESHOLD_RAD).all())
    along = np.array(DIRECTION_ENDOSCOPE[correction.direction])
    return bool((moved_m[rows] @ along >= MIN_M).all())


def _responses(
    episode: Episode, instruction: Instruction, by: Speaker, rng: np.random.Generator
) -> Iterator[CorrectionResponse]:
    """Yield the response to each harmless, possible correction, from the same state."""
    able = [c for c in CORRECTIONS if is_harmless(c, episode.world) and _has_room(c, episode.world)]
    by_chance = _done_unasked(able, episode, instruction)
    for correction in able:
        heard = correction.text if by == "person" else ""
        said = replace(instruction, correction=None if heard else correction)
        response = _response(episode, said, correction, heard)
        response = replace(response, by_chance=correction in by_chance)
        if by == "planner" and correction.direction is not None:
            told_m = harmless_m(correction, episode.world, rng)
            gone_m = _distance_m(episode, replace(said, left_m=told_m))
            response = replace(response, told_m=told_m, gone_m=gone_m)
        yield response


def _done_unasked(
    able: Sequence[Correction], episode: Episode, instruction: Instruction
) -> set[Correction]:
    """Return the corrections that the controller carries out by chance, without a correction."""
    start, done = episode.world.observe(), set[Correction]()
    with _forked(episode, replace(instruction, correction=None)) as fork:
        for _ in islice(fork.steps(), WITHIN_STEPS):
            done |= {c for c in able if is_obeyed(c, *_motion(start, episode.world.observe()))}
    return done


def _distance_m(episode: Episode, said: Instruction) -> float:
    """Return how far the arm has gone as it was told, at the end of the time for it."""
    start = episode.world.observe()
    with _forked(episode, replace(said, time_s=start.time_s)) as fork:
        for _ in islice(fork.steps(), DISTANCE_STEPS):
            pass
        assert said.correction is not None, "a correction was given"
        return moved_m(said.correction, _motion(start, episode.world.observe())[0])


def _motion(start: Observation, now: Observation) -> tuple[Array, Array]:
    """Return the motions of the tips (2, 3), endoscope frame, and of the jaws (2,)."""
    moved_m = (now.tips_endoscope - start.tips_endoscope)[:, :3, 3]
    return moved_m, now.joints[:, 6] - start.joints[:, 6]


def _has_room(correction: Correction, world: World) -> bool:
    """Return whether the jaws can still move as the correction says."""
    jaw, (closed, opened) = world.arms.joints[:, 6], world.arms.limits[:, 6].T
    room = {"open": opened - jaw, "close": jaw - np.maximum(closed, 0.0), None: np.ones(2)}
    return bool((room[correction.jaw][correction.rows] > THRESHOLD_RAD).all())


def _response(
    episode: Episode, said: Instruction, correction: Correction, heard: str
) -> CorrectionResponse:
    start = episode.world.observe()  # whether the arms obeyed is judged exactly
    asked_m, altered = np.zeros((2, 3)), False
    asked_rad = start.joints[:, 6]
    with _forked(episode, said) as fork:
        if heard:
            fork.inbox.say(heard)
        for step in islice(fork.steps(), WITHIN_STEPS):
            if is_obeyed(correction, *_motion(start, episode.world.observe())):
                return CorrectionResponse(text=correction.text, obeyed=True)
            if step.asked is not None:
                asked_m, asked_rad = asked_m + step.asked.move_endoscope_m, step.asked.jaw_rad
            altered = altered or bool(step.altered)
    wanted = is_obeyed(correction, asked_m, asked_rad - start.joints[:, 6])
    return CorrectionResponse(text=correction.text, obeyed=False, withheld=wanted and altered)


def _goes_to_the_other_tube(episode: Episode) -> bool:
    """Return whether the jaws reach the right tube when instructed to clip it before its turn."""
    with _forked(episode, Instruction(task=OTHER_CLIP)) as fork:
        meant = structure_of(OTHER_CLIP, fork.world)
        for _ in islice(fork.steps(), WRONG_TUBE_STEPS):
            T, tool = fork.world.arms.T_world_tool()[RIGHT_ARM], fork.world.arms.mounted[RIGHT_ARM]
            between = between_jaws(fork.world.tubes, T, tool.name) & set(fork.world.organ.tubes)
            if between:
                return between == {meant}
    return False


@contextmanager
def _forked(episode: Episode, said: Instruction) -> Iterator[Episode]:
    """Yield an episode in the same world under one instruction; then restore the world."""
    world, state = episode.world, episode.world.state()
    sense = deepcopy(episode.sense, {id(world): world})  # the sense has a memory
    episode.controller.reset()
    fork = Episode(
        config=episode.config,
        world=world,
        planner=PlannerFixed(instruction=said),
        controller=episode.controller,
        sense=sense,
        observation=sense.observe(world, world.observe()),
    )
    fork.guarded_driver.driver.follow(world.target)
    try:
        yield fork
    finally:
        world.restore(state)
        episode.controller.reset()


def obedience_table(trials: Sequence[ObedienceTrial]) -> Table:
    """Return how often each correction was obeyed, and how often the instructed tube was chosen.

    A correction that was withheld (see `CorrectionResponse`) counts as not obeyed.
    """
    responses = [response for trial in trials for response in trial.responses]
    title = f"words obeyed, seeds {trials[0].seed} to {trials[-1].seed}"
    figures = ("times", "obeyed", "withheld", "share (95 % Wilson interval)", "by chance")
    table = table_of(title, ("said",), figures, ())
    for correction in CORRECTIONS:
        _add_responses(table, correction.text, [r for r in responses if r.text == correction.text])
    table.add_section()
    _add_responses(table, "all corrections", responses)
    told = [response for response in responses if response.told_m is not None]
    _add(table, "with a distance, gone right", sum(r.right_distance for r in told), len(told))
    tubes = [trial.wrong_tube for trial in trials if trial.wrong_tube is not None]
    _add(table, "to the tube whose turn it is not", sum(tubes), len(tubes))
    return table


def _add_responses(table: Table, said: str, responses: Sequence[CorrectionResponse]) -> None:
    obeyed, withheld, by_chance = (
        sum(getattr(response, name) for response in responses)
        for name in ("obeyed", "withheld", "by_chance")
    )
    chance = f"{by_chance / len(responses):.3f}" if responses else ""
    _add(table, said, obeyed, len(responses), str(withheld), chance)


def _add(
    table: Table, said: str, obeyed: int, times: int, withheld: str = "", by_chance: str = ""
) -> None:
    share = "never said" if times == 0 else _share(obeyed, times)
    table.add_row(said, str(times), str(obeyed), withheld, share, by_chance)


def _share(obeyed: int, times: int) -> str:
    low, high = wilson_interval(obeyed, times)
    return f"{obeyed / times:.3f} ({low:.3f} to {high:.3f})"
