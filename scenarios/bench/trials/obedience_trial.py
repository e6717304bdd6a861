"""Check whether one patient's controller obeys each correction, and the order of the wrong tube.

The controller alone carries out a planner's correction; a person's correction is carried out by
rule. All corrections at one time of an episode start from the same saved state.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass, replace
from itertools import islice
from typing import Literal

import numpy as np
from rich.table import Table

from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE, Correction
from planner.instruction import Instruction
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.outcomes import structure_of
from scenarios.bench.trials.run_trials import Trial
from scenarios.demonstration.interjections import PlannerFixed, is_harmless
from scenarios.demonstration.labels import THRESHOLD_RAD
from scenarios.episode import Episode
from scenarios.files.outside_text import table_of
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import wilson_interval
from scenarios.run_episode import begin
from tissue_sim.frames import Array
from tissue_sim.patient.tubes import between_jaws
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.world import World

Speaker = Literal["planner", "person"]
FIRST_CLIP = CHOLECYSTECTOMY.of("clip", "left", 1)
OTHER_CLIP = CHOLECYSTECTOMY.of("clip", "right", 1)
MOMENTS = 4  # of each episode
FIRST_S, LAST_S = 1.0, 36.0  # range of their times; an episode lasts about 40 s
MIN_M = 3e-3  # motion in the named direction that counts as obeyed
WITHIN_STEPS = 60  # 2 s
WRONG_TUBE_STEPS = 600  # 20 s: a clip takes 3


@dataclass(frozen=True, kw_only=True)
class CorrectionResponse:
    """One correction in one state, and the controller's response.

    Attributes:
        obeyed: The arm or the jaws moved as the correction says.
        withheld: The arm or the jaws did not move as the correction says, although the controller's
            actions add up to that motion. The safety filter changed some command meanwhile.
    """

    text: str
    obeyed: bool
    withheld: bool = False


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
    moments_s = sorted(np.random.default_rng(seed).uniform(FIRST_S, LAST_S, MOMENTS).tolist())
    responses, wrong_tube = list[CorrectionResponse](), None
    for step in episode.steps():
        if wrong_tube is None and step.instruction.task == FIRST_CLIP:
            wrong_tube = _goes_to_the_other_tube(episode)
        if moments_s and step.time_s >= moments_s[0] and not step.exchange:
            responses += _responses(episode, step.instruction, by)
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
    episode: Episode, instruction: Instruction, by: Speaker
) -> Iterator[CorrectionResponse]:
    """Yield the response to each harmless, possible correction, from the same state."""
    for correction in CORRECTIONS:
        if is_harmless(correction, episode.world) and _has_room(correction, episode.world):
            said = replace(instruction, correction=correction if by == "planner" else None)
            heard = correction.text if by == "person" else ""
            yield _response(episode, said, correction, heard)


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
            observation = episode.world.observe()
            moved_m = (observation.tips_endoscope - start.tips_endoscope)[:, :3, 3]
            if is_obeyed(correction, moved_m, observation.joints[:, 6] - start.joints[:, 6]):
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
    given, obeyed = (
        Counter(r.text for r in responses),
        Counter(r.text for r in responses if r.obeyed),
    )
    withheld = Counter(r.text for r in responses if r.withheld)
    title = f"words obeyed, seeds {trials[0].seed} to {trials[-1].seed}"
    figures = ("times", "obeyed", "withheld", "share (95 % Wilson interval)")
    table = table_of(title, ("said",), figures, ())
    for correction in CORRECTIONS:
        text = correction.text
        _add(table, text, obeyed[text], given[text], str(withheld[text]))
    table.add_section()
    _add(table, "all corrections", obeyed.total(), given.total(), str(withheld.total()))
    tubes = [trial.wrong_tube for trial in trials if trial.wrong_tube is not None]
    _add(table, "to the tube whose turn it is not", sum(tubes), len(tubes))
    return table


def _add(table: Table, said: str, obeyed: int, times: int, withheld: str = "") -> None:
    share = "never said" if times == 0 else _share(obeyed, times)
    table.add_row(said, str(times), str(obeyed), withheld, share)


def _share(obeyed: int, times: int) -> str:
    low, high = wilson_interval(obeyed, times)
    return f"{obeyed / times:.3f} ({low:.3f} to {high:.3f})"
