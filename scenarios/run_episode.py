"""Set an episode up, play it to its end, and judge it."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from controller.base import Controller
from planner.base import Planner
from planner.policy_setup import is_privileged
from planner.procedure.outcomes import why_call
from planner.rules.rule_use import rule_uses_of
from scenarios.catalogue import SCENARIOS, procedure_named, sense_named
from scenarios.episode import Episode
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.motion_metrics import MotionMetrics
from scenarios.loop.observer import Observer
from scenarios.loop.person.inbox import Inbox
from scenarios.loop.person.script import read_script
from scenarios.loop.policies import make_controller, make_person, make_planner, name_of
from scenarios.loop.results import (
    CallResult,
    EpisodeResult,
    InjuryResult,
    PeakResult,
    SafetyResult,
)
from scenarios.loop.senses import make_sense
from scenarios.loop.sensing_metrics import SensingMetrics
from scenarios.perturbation.effects import Effects
from tissue_sim.outcome.margins import margins
from tissue_sim.outcome.predicates import stumps_hold, untouched
from tissue_sim.outcome.retention import pull_all_clips
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.variants import patient_of
from tissue_sim.sensing.observation import Observation
from tissue_sim.world import World


def run_episode(
    config: EpisodeConfig,
    observers: Sequence[Observer] = (),
    inbox: Inbox | None = None,
    *,
    planner: Planner[Observation] | None = None,
    controller: Controller | None = None,
) -> EpisodeResult:
    """Run one episode to its end and judge it.

    An exception ends the episode and is the caller's to record: it is no failed episode.

    Args:
        config: Names the patient, the conditions and the policies.
        observers: Receive each step.
        inbox: Queue of people's input to the episode.
        planner: An object to use in place of the configured planner.
        controller: The same for the controller.
    """
    start_s = time.perf_counter()
    render = any(getattr(o, "needs_images", False) for o in observers)
    inbox = inbox or Inbox()
    episode = begin(config, render=render, inbox=inbox, planner=planner, controller=controller)
    return play(episode, [*observers, *make_person(config, inbox)], start_s)


def play(episode: Episode, observers: Sequence[Observer], start_s: float) -> EpisodeResult:
    """Play an episode to its end and judge it; the episode began at `start_s` of `perf_counter`."""
    for observer in observers:
        observer.on_reset(episode.world)
    metrics, sensing = MotionMetrics(episode.world), SensingMetrics()
    for step in episode.steps():
        metrics.on_step(step)
        sensing.on_step(step)
        for observer in observers:
            observer.on_step(step)
    result = result_of(episode, start_s)
    result = replace(
        result,
        tasks=metrics.measured(result.tasks),
        sensing=None if episode.config.sense == "exact" else sensing.result(),
    )
    for observer in observers:
        observer.on_end(result)
    return result


def begin(
    config: EpisodeConfig,
    *,
    render: bool = False,
    inbox: Inbox | None = None,
    planner: Planner[Observation] | None = None,
    controller: Controller | None = None,
    effects: Effects | None = None,
) -> Episode:
    """Put the patient on the table and make planner and controller ready; nothing moves yet."""
    inbox = inbox or Inbox()
    effects = effects or Effects(config.perturbations, config.seed)
    if config.instruct is not None:
        inbox.arrange(read_script(Path(config.instruct)))
    procedure_named(config.procedure)  # its module may bring instruments, which the world mounts
    render = render or sense_named(config.sense).renders or bool(config.cameras)
    world = patient_on_table(config, effects, render=render)
    sense = make_sense(config, effects)
    return Episode(
        world=world,
        sense=sense,
        planner=planner or make_planner(config, world),
        controller=controller or make_controller(config, world),
        inbox=inbox,
        effects=effects,
        observation=sense.observe(world, world.observe()),
        config=replace(
            config,
            planner=name_of(planner) if planner else config.planner,
            controller=name_of(controller) if controller else config.controller,
        ),
    )


def patient_on_table(config: EpisodeConfig, effects: Effects, *, render: bool = False) -> World:
    """Make the world of an episode, with its patient."""
    world = World(render=render)
    world.reset(effects.on_anatomy(anatomy_of(config)))
    return world


def anatomy_of(config: EpisodeConfig) -> Anatomy:
    """Return the seed's patient in the scenario."""
    return patient_of(config.seed, SCENARIOS[config.scenario].variant)


def result_of(episode: Episode, start_s: float) -> EpisodeResult:
    """Judge the episode, which began at `start_s` of `perf_counter`."""
    config, world, record = episode.config, episode.world, episode.tasks
    tasks = record.in_order()
    procedure_s = world.record.time_s - episode.exchange_s
    judged = judge(world, complete=record.is_complete)
    policies = {"planner": episode.planner, "controller": episode.controller}
    return EpisodeResult(
        scenario=config.scenario,
        procedure=config.procedure,
        seed=config.seed,
        planner=config.planner,
        controller=config.controller,
        sense=config.sense,
        privileged=tuple(role for role, policy in policies.items() if is_privileged(policy)),
        success=judged.success,
        call=_call(episode),
        tasks=tasks,
        procedure_time_s=procedure_s,
        exchange_time_s=episode.exchange_s,
        wall_s=time.perf_counter() - start_s,
        act=episode.acts.worst,
        corrections=sum(task.corrections for task in tasks),
        dropped_clips=judged.dropped_clips,
        injuries=judged.injuries,
        peaks=judged.peaks,
        safety=_safety(episode),
        rules=rule_uses_of(*policies.values()),
        anatomy_hash=judged.anatomy_hash,
        tubes=judged.tubes,
    )


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """The judgement of the patient, by the names of `EpisodeResult`."""

    success: bool
    dropped_clips: int
    injuries: tuple[InjuryResult, ...]
    peaks: tuple[PeakResult, ...]
    anatomy_hash: str
    tubes: tuple[str, ...]


def judge(world: World, *, complete: bool) -> Judgement:
    """Pull at the clips, and judge the patient after an episode whose tasks are complete or not."""
    if complete:  # otherwise the pull would stretch uncut tissue
        pull_all_clips(world)
    injuries = world.record.injuries
    return Judgement(
        success=complete and stumps_hold(world) and not injuries,
        dropped_clips=world.record.dropped_clips,
        injuries=tuple(
            InjuryResult(event=i.event, time_s=i.time_s, value=i.value, limit=i.limit)
            for i in injuries
        ),
        peaks=_peaks(world),
        anatomy_hash=world.anatomy.hash,
        tubes=tuple(world.anatomy.tubes),
    )


def _call(episode: Episode) -> CallResult | None:
    said, world = episode.instruction, episode.world
    if not said.call:
        return None
    return CallResult(
        reason=said.remark,
        in_time=untouched(world),
        needed=why_call(episode.procedure, world.anatomy) is not None,
    )


def _peaks(world: World) -> tuple[PeakResult, ...]:
    """Return the peaks of the quantities with an injury limit, and the margins of the clips."""
    injuries = (PeakResult(event=p.event, value=p.value, limit=p.limit) for p in world.record.peaks)
    clips = (
        PeakResult(event=m.measure, value=m.value, limit=m.limit, at_least=m.at_least)
        for m in margins(world)
    )
    return (*injuries, *clips)


def _safety(episode: Episode) -> SafetyResult:
    guarded = episode.guarded_driver
    ledger = tuple(guarded.ledger.entries)
    return SafetyResult(
        filter=guarded.filter is not None,
        interventions=len(ledger),
        min_clearance_m=guarded.clearance_m if math.isfinite(guarded.clearance_m) else None,
        ledger=ledger,
    )
