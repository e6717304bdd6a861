"""Answer a person's questions, from the observation and the robot's next actions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from planner.instruction import Instruction
from planner.language.rules.questions import Question, Thing
from planner.person import findings
from planner.person.findings import Asked, counts, within_mm
from planner.person.premises import REASONS, Claim, denial
from planner.person.readiness import safe
from planner.person.remaining import left, tasks_left
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.procedure import Procedure
from planner.scene.in_words import all_tubes
from planner.scene.predicates import has_slipped
from tissue_sim.sensing.observation import Observation


def answer(
    question: Question,
    instruction: Instruction,
    observation: Observation,
    about: Thing | None = None,
    claims: Sequence[Claim] = (),
    procedure: Procedure = CHOLECYSTECTOMY,
) -> str:
    """Return the answer in a few short sentences, with a denial of wrong claims."""
    if wrong := denial(claims, instruction.task, observation):
        return wrong
    if question == "why" and claims:
        return " ".join(REASONS[claim.claimed] for claim in claims)
    asked = Asked(
        instruction=instruction, observation=observation, procedure=procedure, about=about
    )
    if asked.lacks and question not in ("which", "forbidden"):
        return asked.lacks
    return ANSWERS[question](asked)


def doing_in_words(instruction: Instruction) -> str:
    """Return the robot's present action in words: "I go on: grabbing gallbladder."."""
    if instruction.call:
        return "I hold and have called for a person."
    if instruction.hold:
        return "I hold."
    return f"I go on: {instruction.text}."


def _doing(asked: Asked) -> str:
    instruction = asked.instruction
    if instruction.hold and instruction.remark:
        return _sentence(instruction.remark)
    return "You asked for it." if instruction.source == "human" else "The planner asks for it."


_BEFORE = {True: "before anything is clipped", False: "first"}


def _why(asked: Asked) -> str:
    instruction = asked.instruction
    if instruction.remark:
        return f"Because: {_sentence(instruction.remark)}"
    if instruction.source == "human":
        return "Because a person asked for it."
    if instruction.correction is not None:
        return f"Because {instruction.task.text!r} seems to go wrong without it."
    if instruction.task.grasps:
        clips = any(task.places_clip for task in asked.procedure.tasks)
        return f"Because the gallbladder has to be held {_BEFORE[clips]}."
    if instruction.task.goes_back:
        return "Because the right arm has to be clear before the next step."
    return f"Because it is next: {counts(asked.observation)}."


def _next(asked: Asked) -> str:
    left = tasks_left(asked.instruction.task, asked.observation, asked.procedure)
    task = next((task for task in left if not (task.grasps or task.goes_back)), None)
    if task is not None:
        return f"Next that is not done: {task.text}."
    every = f"{all_tubes(asked.observation)} are cut" if asked.observation.all_severed else ""
    return f"{every.capitalize() or 'All else is done'}: the arm goes back."


def _wrong(asked: Asked) -> str:
    instruction = asked.instruction
    if instruction.call:
        return f"Something is wrong: {_sentence(instruction.remark)}"
    if has_slipped(asked.observation) and not instruction.task.grasps:
        return "Something is wrong: the grasper does not hold the gallbladder."
    if (judged := instruction.assessment) is not None:
        chance = f"I give this task a chance of failure of {judged.failure_chance:.0%}."
        return f"It may go wrong: {chance}" if judged.alarm else f"I see nothing wrong: {chance}"
    return "I see nothing wrong."


def _sure(asked: Asked) -> str:
    instruction, observation = asked.instruction, asked.observation
    there = observation.there
    std_m = observation.std_m[there][~observation.hidden[there]]
    points = f"points to within about {within_mm(std_m)}" if len(std_m) else "nothing"
    right = f"{instruction.confidence:.0%} that {instruction.text!r} is right now; I see {points}."
    return f"{findings.which(asked)} {right}"


def _forbidden(asked: Asked) -> str:
    forbidden = ", ".join(asked.instruction.forbidden)
    always = "Before its clips are seen on it, no tube is cut."
    return f"You forbade: {forbidden}. {always}" if forbidden else f"You forbade nothing. {always}"


def _sentence(remark: str) -> str:
    """Return a remark with the end of a sentence."""
    return remark if remark.endswith((".", "!", "?")) else f"{remark}."


ANSWERS: dict[Question, Callable[[Asked], str]] = {
    "doing": _doing,
    "why": _why,
    "next": _next,
    "left": left,
    "clips": findings.clips,
    "on": findings.on,
    "cut": findings.cut,
    "held": findings.held,
    "which": findings.which,
    "where": findings.where,
    "distance": findings.distance,
    "wrong": _wrong,
    "sure": _sure,
    "safe": safe,
    "forbidden": _forbidden,
}
"""The function that answers each kind of question."""
