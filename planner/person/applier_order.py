"""Interpret a person's choice between the clip appliers: for which tube, and whether it fits."""

from __future__ import annotations

from planner.language.reading import Applier, Reading
from planner.person.findings import tube_named
from planner.procedure.task import Task
from planner.scene.duct_side import duct_side, structure_seen, tubes_in_order
from planner.scene.next_task import (
    NotNowError,
    applier_on,
    clips_needed_on,
    clips_on,
    require_there,
)
from planner.scene.predicates import is_back
from tissue_sim.patient.tube_names import Tube
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.instruments import Instrument, appliers, clip_of


def tube_meant(reading: Reading, task: Task, observation: Observation) -> Tube:
    """Return the tube whose next clip a person chooses the applier for.

    The tube is that of the command, else the named one, else that of the task in force, else the
    next that lacks a clip.

    Raises:
        NotNowError: The tube is not there, or no tube lacks a clip.
    """
    command = reading.command and reading.command.seen(duct_side(observation))
    named = command and (command.tube or (command.task and command.task.tube))
    if named := named or tube_named(reading.about, observation):
        require_there(named, observation)
        return named
    order: list[Tube] = [task.tube] if task.tube else []
    for tube in (*order, *tubes_in_order(observation)):
        if _lacks_a_clip(tube, observation):
            return tube
    raise NotNowError("no tube lacks a clip")


def chosen_applier(said: Applier, tube: Tube, observation: Observation) -> Instrument:
    """Return the applier that a person wants for a tube.

    Raises:
        NotNowError: The applier's clip is for other vessels than the tube.
    """
    slim, large = appliers()
    mounted = observation.right_instrument
    present = mounted if mounted.clip else applier_on(tube, observation)
    other = large if present == slim else slim
    wanted = {"slim": slim, "large": large, "other": other}[said]
    clip, wide_m = clip_of(wanted), 2.0 * observation.radius_m(tube)
    if not clip.fits(wide_m):
        least, most = (f"{1e3 * end_m:.1f}" for end_m in clip.vessel_m)
        sizes = f"{least} to {most} mm" if clip.vessel_m[0] else f"up to {most} mm"
        name = structure_seen(tube, observation)
        raise NotNowError(
            f"the {name} looks {1e3 * wide_m:.1f} mm wide, and a {clip.name} clip is for {sizes}"
        )
    return wanted


def choice_in_words(applier: Instrument, tube: Tube, observation: Observation) -> str:
    """Return the choice in words: "I take the slim clip applier for the artery."."""
    waits = observation.right_instrument != applier and not is_back(observation)
    when = ", once the right arm is back" if waits else ""
    return (
        f"I take the {applier.in_words}, with {clip_of(applier).name} clips, for the"
        f" {structure_seen(tube, observation)}{when}."
    )


def _lacks_a_clip(tube: Tube, observation: Observation) -> bool:
    there = tube in observation.tubes and not observation.is_severed(tube)
    return there and clips_on(tube, observation) < clips_needed_on(tube, observation)
