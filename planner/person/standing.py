"""Keep a person's words that stand until other words: prohibitions, appliers, and the speed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from planner.instruction import Instruction
from planner.person.prohibition import Prohibition, act_of
from planner.procedure.task import Task
from tissue_sim.patient.tube_names import Tube
from tissue_sim.sensing.observation import Observation

SPEEDS = {"slower": 0.5, "half": 0.5, "normal": 1.0, "faster": 2.0}
SLOWEST, FASTEST = 0.125, 1.0  # shares of the usual speed, which is that of the limits


class Standing:
    """Keeps forbidden acts until they are allowed, and wishes until other ones are told.

    Attributes:
        forbidden: Forbidden acts, with tubes as structures.
        speed: Share of the usual speed.
        appliers: Name of the clip applier that a person chose for a tube.
    """

    def __init__(self) -> None:
        self.forbidden: set[Prohibition] = set()
        self.speed = 1.0
        self.appliers: dict[Tube, str] = {}

    def forbid(self, acts: Iterable[Prohibition], observation: Observation) -> None:
        """Forbid acts until they are allowed."""
        self.forbidden |= {one.seen(observation) for one in acts}

    def allow(self, said: Prohibition, observation: Observation) -> str:
        """Lift the bans that an allowance covers; return them in words, "" if there are none."""
        allowed = said.seen(observation)
        left = {part for one in self.forbidden for part in one.without(allowed)}
        if left == self.forbidden:
            return ""
        lifted = {one for one in self.forbidden - left if allowed.covers(one)} or {allowed}
        self.forbidden = left
        rest = ", ".join(_listed(left, observation))
        still = f" Still forbidden: {rest}." if rest else ""
        return f"Allowed again: {', '.join(_listed(lifted, observation))}.{still}"

    def covered_by(self, said: Prohibition, observation: Observation) -> bool:
        """Return whether an allowance would lift any ban."""
        allowed = said.seen(observation)
        return any(one.without(allowed) != (one,) for one in self.forbidden)

    def forbids(self, act: Prohibition) -> bool:
        """Return whether an act is forbidden."""
        return any(one.covers(act) for one in self.forbidden)

    def listed(self, observation: Observation) -> tuple[str, ...]:
        """Return the forbidden acts in words."""
        return _listed(self.forbidden, observation)

    def forbidden_in(self, task: Task, observation: Observation) -> Prohibition | None:
        """Return the act of a task if it is forbidden."""
        if not self.forbidden:
            return None
        act = act_of(task, observation)
        return act if act is not None and self.forbids(act) else None

    def applied_to(self, asked: Instruction, observation: Observation) -> Instruction:
        """Return an instruction as it is in force: both arms hold where its act is forbidden.

        A person's correction is carried out all the same, but the jaws do not act.
        """
        corrected = asked.source == "human" and asked.correction is not None
        act = None if corrected or asked.hold else self.forbidden_in(asked.task, observation)
        if act is not None:
            why = f"You forbade: {act.in_words}."
            asked = replace(asked, correction=None, hold=True, remark=why)
        task = asked.task
        chosen = self.appliers.get(task.tube) if task.tube and task.places_clip else None
        forbidden = self.listed(observation)
        return replace(asked, tool=chosen or asked.tool, forbidden=forbidden, speed=self.speed)

    def set_speed(self, said: str) -> None:
        """Take in "slower", "half", "normal" or "faster"."""
        factor = SPEEDS[said] if said in ("normal", "half") else self.speed * SPEEDS[said]
        self.speed = min(max(factor, SLOWEST), FASTEST)


def _listed(acts: Iterable[Prohibition], observation: Observation) -> tuple[str, ...]:
    """Return acts in words, without those on a tube that is not there, or not seen yet."""
    there = [one for one in acts if one.is_possible(observation)]
    return tuple(sorted(one.in_words for one in there))
