"""Answers to a person's questions, from what the robot sees and is about to do."""

from __future__ import annotations

import numpy as np

from planner.command import TUBES
from planner.instruction import Instruction
from planner.language.rules.questions import Question
from planner.seen.done import has_slipped
from planner.seen.duct_side import structure_seen
from planner.seen.next_task import clips_needed_on, clips_on, lying_on, next_of_all
from planner.task import Tube
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import MAX_CLIPS, N_LINE, Observation
from tissue_sim.sensing.polyline import distance_to_line_m
from tissue_sim.tools.arms import RIGHT_ARM


def answer(question: Question, instruction: Instruction, seen: Observation) -> str:
    """Return the answer in one or two short sentences."""
    return {
        "doing": _doing,
        "why": _why,
        "next": _next,
        "clips": _clips,
        "on": _on,
        "wrong": _wrong,
        "sure": _sure,
        "distance": _distance,
    }[question](instruction, seen)


def doing_in_words(instruction: Instruction) -> str:
    """Return what the robot does now: "I go on: grabbing gallbladder."."""
    if instruction.call:
        return "I hold and have called for a person."
    if instruction.hold:
        return "I hold."
    return f"I go on: {instruction.text}."


def _doing(instruction: Instruction, seen: Observation) -> str:
    del seen
    if instruction.hold and instruction.remark:
        return _sentence(instruction.remark)
    return "You asked for it." if instruction.source == "human" else "The planner asks for it."


def _why(instruction: Instruction, seen: Observation) -> str:
    if instruction.remark:
        return f"Because: {_sentence(instruction.remark)}"
    if instruction.source == "human":
        return "Because a person asked for it."
    if instruction.correction is not None:
        return f"Because {instruction.task.text!r} seems to go wrong without it."
    task, counts = instruction.task, _counts(seen)
    if task.kind == "grab":
        return "Because the gallbladder has to be held before anything is clipped."
    if task.goes_back:
        return "Because the right arm has to be clear before the next step."
    return f"Because it is next: {counts}."


def _next(instruction: Instruction, seen: Observation) -> str:
    del instruction
    task = next_of_all(seen)
    return (
        f"Next that is not done: {task.text}." if task else "Both tubes are cut: the arm goes back."
    )


def _clips(instruction: Instruction, seen: Observation) -> str:
    del instruction
    return f"I see {_counts(seen)}."


def _on(instruction: Instruction, seen: Observation) -> str:
    tube = instruction.task.tube
    if tube is None:
        return f"I see {_counts(seen)}."
    clips = np.flatnonzero(lying_on(tube, seen))
    last_m = seen.std_m[N_LINE + clips[-1:]]
    placed = len(last_m) and not seen.severed[TUBES.index(tube)]
    how = f", the last one to within {_within_mm(last_m)}" if placed else ""
    return f"I see {_on_tube(tube, seen)}{how}. Whether a clip would hold a pull I cannot see."


def _wrong(instruction: Instruction, seen: Observation) -> str:
    if instruction.call:
        return f"Something is wrong: {_sentence(instruction.remark)}"
    if has_slipped(seen) and instruction.task.kind != "grab":
        return "Something is wrong: the grasper does not hold the gallbladder."
    if (judged := instruction.assessment) is not None:
        chance = f"I give this task a chance of failure of {judged.failure_chance:.0%}."
        return f"It may go wrong: {chance}" if judged.alarm else f"I see nothing wrong: {chance}"
    return "I see nothing wrong."


def _sure(instruction: Instruction, seen: Observation) -> str:
    there = slice(N_LINE + min(seen.n_clips, MAX_CLIPS))
    std_m = seen.std_m[there][~seen.hidden[there]]
    points = f"points to within about {_within_mm(std_m)}" if len(std_m) else "nothing"
    return f"{instruction.confidence:.0%} that {instruction.text!r} is right now; I see {points}."


def _sentence(remark: str) -> str:
    """Return a remark that ends as a sentence does."""
    return remark if remark.endswith((".", "!", "?")) else f"{remark}."


def _within_mm(std_m: Array) -> str:
    """Return what 95 % of the errors along an axis stay below, of the median point (n,)."""
    return f"{2e3 * float(np.median(std_m)):.1f} mm"


def _distance(instruction: Instruction, seen: Observation) -> str:
    del instruction
    tip_m = seen.tips_endoscope[RIGHT_ARM, :3, 3]
    lines = (
        ("common bile duct", seen.common_bile_duct_m),
        ("hepatic artery", seen.hepatic_artery_m),
    )
    far = " and ".join(f"{1e3 * _to_line_m(tip_m, line):.0f} mm from the {n}" for n, line in lines)
    return f"The right tip is {far}, measured to their middle lines."


def _to_line_m(tip_m: Array, line_m: Array) -> float:
    return float(distance_to_line_m(tip_m[None], line_m)[0])


def _counts(seen: Observation) -> str:
    return " and ".join(_on_tube(tube, seen) for tube in TUBES)


def _on_tube(tube: Tube, seen: Observation) -> str:
    """Return the state of a tube in words: "2 of 3 clips on the duct"."""
    name = structure_seen(tube, seen)
    if seen.severed[TUBES.index(tube)]:
        return f"the {name} cut"
    n = clips_on(tube, seen)
    return f"{n} of {clips_needed_on(tube, seen)} clips on the {name}"
