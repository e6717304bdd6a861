"""Compare a person's claims with the observation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from planner.procedure.task import Task
from planner.scene.duct_side import structure_seen, tube_of
from planner.scene.next_task import clips_needed_on, clips_on
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.patient.tube_names import TUBES, USUAL_TUBES, Tube
from tissue_sim.sensing.observation import Observation
from tissue_sim.thresholds import HELD_PINCH_N

Claimed = Literal["cut", "clipped", "clip on", "held", "dropped"]
Where = Literal["duct", "artery", "left tube", "right tube", "third tube", "both", ""]
REASONS: dict[Claimed, str] = {
    "cut": "A tube is cut once its clips are seen on it.",
    "clipped": "A tube gets its clips before it is cut.",
    "clip on": "A tube gets its clips before it is cut.",
    "held": "The gallbladder has to be held before anything is clipped.",
    "dropped": "The grasper's jaws press on nothing: it has slipped out, or they were opened.",
}
"""The reason why a claimed act was done, where it was done."""
ORDINALS = ("first", "second", "third")


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A claim of a person about the state: "the duct is cut".

    Attributes:
        claimed: The claimed state. A tube is cut or has its clips, a clip is on, or the gallbladder
            is held or was released.
        on: The tube; "" for the tube at hand.
        n: The claimed number of clips; None for the clip at hand.
    """

    claimed: Claimed
    on: Where = ""
    n: int | None = None


def denial(claims: Iterable[Claim], task: Task, observation: Observation) -> str:
    """Return in words the observation that contradicts a claim; "" if all claims are true.

    Args:
        claims: The person's claims.
        task: The task in force, which determines the tube and clip at hand.
        observation: The present observation.
    """
    return next(filter(None, (_denial(claim, task, observation) for claim in claims)), "")


def clips_in_words(tube: Tube, observation: Observation) -> str:
    """Return in words the number of clips observed on a tube: "no clip is on it"."""
    n, needed = clips_on(tube, observation), clips_needed_on(tube, observation)
    if n == 0:
        return "no clip is on it"
    if n >= needed:
        return f"its {n} clips are on it"
    return f"{n} of {needed} clips {'is' if n == 1 else 'are'} on it"


def _denial(claim: Claim, task: Task, observation: Observation) -> str:
    if claim.claimed in ("held", "dropped"):
        return _of_the_grasp(claim, observation)
    tubes = _tubes(claim.on, task, observation)
    if claim.on == "" and len(tubes) > 1:  # one of the tubes is enough
        wrong = [_of_a_tube(claim, tube, task, observation) for tube in tubes]
        return wrong[0] if all(wrong) else ""
    return next(filter(None, (_of_a_tube(claim, tube, task, observation) for tube in tubes)), "")


def _of_the_grasp(claim: Claim, observation: Observation) -> str:
    held = observation.pinch_n >= HELD_PINCH_N
    if claim.claimed == "held":
        return "" if held else "The grasper does not hold the gallbladder."
    return "The grasper has not let go: it holds the gallbladder." if held else ""


def _of_a_tube(claim: Claim, tube: Tube, task: Task, observation: Observation) -> str:
    if tube not in observation.tubes:
        return f"There is no {tube} tube here."
    name, count = structure_seen(tube, observation), clips_in_words(tube, observation)
    severed = observation.is_severed(tube)
    n, needed = clips_on(tube, observation), clips_needed_on(tube, observation)
    if severed:
        return ""
    if claim.claimed == "cut":
        return f"The {name} is not cut: {count}."
    if claim.claimed == "clipped":
        return "" if n >= needed else f"The {name} is not clipped: {count}."
    at_hand = task.clip if task.tube == tube else None
    if claim.n is None and at_hand:
        last = needed if at_hand == USUAL_CLIPS else at_hand
        return "" if n >= last else f"The {ORDINALS[last - 1]} clip is not on the {name}: {count}."
    claimed = claim.n or 1
    return "" if n >= claimed else f"{_so_many(claimed)} not on the {name}: {count}."


def _so_many(n: int) -> str:
    return "A clip is" if n == 1 else f"{n} clips are"


def _tubes(on: Where, task: Task, observation: Observation) -> tuple[Tube, ...]:
    """Return the tubes that are meant; if none is named, the tube at hand."""
    if on in ("duct", "artery"):
        return (tube_of(on, observation),)
    if on == "both":
        return USUAL_TUBES
    named: tuple[Tube, ...] = tuple(tube for tube in TUBES if on == f"{tube} tube")
    return named or ((task.tube,) if task.tube else observation.tubes)
